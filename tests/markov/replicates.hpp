// Tests of an estimated image against its exact one from independent replicates of the whole estimate, whose
// scatter is the only measure of error that correlated chain states leave.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "support/statistics.hpp"

namespace mlt::test {

class Replicates {
 public:
  explicit Replicates(std::vector<double> expected)
      : expected_(std::move(expected)), values_(expected_.size()) {}

  void add(const std::vector<double>& image) {
    for (std::size_t i = 0; i < values_.size(); ++i) values_[i].push_back(image[i]);
  }

  /// Smallest p-value of one t-test for each value; compare with sidak_threshold(significance, size()).
  double smallest_p_value() const {
    double smallest = 1;
    for (std::size_t i = 0; i < values_.size(); ++i) {
      smallest = std::min(smallest, student_t_test(moments(values_[i]), expected_[i]).p_value);
    }
    return smallest;
  }

  /// All values at once: Hotelling's T^2, the chi-square over pixels that allows for their correlation and
  /// for estimated variances [Hotelling31]. Needs clearly more replicates than values.
  double joint_p_value() const {
    const std::size_t n = size();
    const double replicates = static_cast<double>(values_[0].size());
    std::vector<double> deviation(n);
    for (std::size_t i = 0; i < n; ++i) deviation[i] = moments(values_[i]).mean - expected_[i];
    std::vector<double> factor = covariance();
    factorise(factor);
    double statistic = 0;
    for (std::size_t i = 0; i < n; ++i) {  // Solves factor * y = deviation; the statistic is |y|^2.
      for (std::size_t j = 0; j < i; ++j) deviation[i] -= factor[i * n + j] * deviation[j];
      deviation[i] /= factor[i * n + i];
      statistic += deviation[i] * deviation[i];
    }
    const double dof_a = static_cast<double>(n);
    const double dof_b = replicates - dof_a;
    const double f = replicates * statistic * dof_b / (dof_a * (replicates - 1));
    return incomplete_beta(dof_b / 2, dof_a / 2, dof_b / (dof_b + dof_a * f));
  }

  std::size_t size() const { return expected_.size(); }
  const std::vector<double>& values(std::size_t index) const { return values_[index]; }
  double expected(std::size_t index) const { return expected_[index]; }

 private:
  std::vector<double> covariance() const {
    const std::size_t n = size();
    const std::size_t replicates = values_[0].size();
    std::vector<double> matrix(n * n);
    for (std::size_t i = 0; i < n; ++i) {
      const double mean_i = moments(values_[i]).mean;
      for (std::size_t j = 0; j <= i; ++j) {
        const double mean_j = moments(values_[j]).mean;
        double sum = 0;
        for (std::size_t r = 0; r < replicates; ++r)
          sum += (values_[i][r] - mean_i) * (values_[j][r] - mean_j);
        matrix[i * n + j] = sum / static_cast<double>(replicates - 1);
      }
    }
    return matrix;
  }

  /// Cholesky's lower triangular factor, in place.
  void factorise(std::vector<double>& a) const {
    const std::size_t n = size();
    for (std::size_t i = 0; i < n; ++i) {
      for (std::size_t j = 0; j <= i; ++j) {
        double sum = a[i * n + j];
        for (std::size_t k = 0; k < j; ++k) sum -= a[i * n + k] * a[j * n + k];
        a[i * n + j] = i == j ? std::sqrt(sum) : sum / a[j * n + j];
      }
    }
  }

  std::vector<double> expected_;
  std::vector<std::vector<double>> values_;  ///< [value][replicate]
};

}  // namespace mlt::test
