#include "geometry/bvh_builder.hpp"

#include <algorithm>

#include "base/assert.hpp"
#include "bvh_shared_split.hpp"
#include "geometry/bvh_workspace.hpp"

namespace mlt {
namespace {

/// Divides `range` into up to kNodeWidth children by split(range).
template <class Split>
void open_node(const Range& range, int level, OpenedNode& node, Split&& split) {
  node.count = 0;
  if (range.count() == 0) return;
  node.children[node.count++] = range;
  while (node.count < kNodeWidth) {
    int widest = -1;
    float most = -1.0f;
    for (int i = 0; i < node.count; ++i) {
      const Range& child = node.children[i];
      if (child.count() <= kLeafSize) continue;
      // Below the last level by surface area, halving the most numerous child bounds the depth.
      const float weight =
          level < kSurfaceAreaLevels ? child.box.half_area() : static_cast<float>(child.count());
      if (weight > most) {
        most = weight;
        widest = i;
      }
    }
    if (widest < 0) break;
    const Pair pair = split(node.children[widest]);
    node.children[widest] = pair.left;
    node.children[node.count++] = pair.right;
  }
}

void write_node(BvhNode& node, const OpenedNode& opened) {
  for (int lane = 0; lane < kNodeWidth; ++lane) {
    const Box box = lane < opened.count ? opened.children[lane].box : Box{};
    const Float4 low = box.low();
    const Float4 high = -box.minus_high();
    for (int axis = 0; axis < 3; ++axis) {
      node.planes[axis][0][lane] = low[axis];
      node.planes[axis][1][lane] = high[axis];
    }
    node.children[lane] = kLeafBit;
  }
}

/// A range that waits for its node or leaf, and where the index of that belongs.
struct Task {
  Range range;
  std::uint32_t parent = 0;
  int lane = 0;
  int level = 0;
};

/// Builds one subtree depth first. Its nodes are numbered as in the whole tree, its leaves from 0.
class SubtreeBuilder {
 public:
  SubtreeBuilder(const BvhStorage& storage, Subtree& subtree) : storage_(storage), subtree_(subtree) {}

  void build() {
    subtree_.size = {};
    tasks_[task_count_++] = {subtree_.range, 0, 0, subtree_.level};
    while (task_count_ > 0) {
      const Task task = tasks_[--task_count_];
      if (task.level > 0 && task.range.count() <= kLeafSize) {
        const std::uint32_t leaf = write_leaf(task.range);
        if (task.level > subtree_.level) storage_.nodes[task.parent].children[task.lane] = leaf;
      } else {
        const std::uint32_t node = make_node(task);
        if (task.level > subtree_.level) storage_.nodes[task.parent].children[task.lane] = node;
      }
    }
  }

 private:
  std::uint32_t make_node(const Task& task) {
    MLT_CHECK_OP(task.level, <, kMaxLevels);
    const std::uint32_t index = subtree_.first_node + subtree_.size.nodes++;
    MLT_CHECK_OP(index, <, storage_.nodes.size());
    subtree_.size.levels = std::max(subtree_.size.levels, task.level + 1);
    OpenedNode node;
    open_node(task.range, task.level, node,
              [&](const Range& range) { return split_range(storage_.references, range, task.level); });
    write_node(storage_.nodes[index], node);
    push_children(node, index, task.level + 1);
    return index;
  }

  /// The child whose references come first is taken up first, so that leaves are numbered in their order.
  void push_children(const OpenedNode& node, std::uint32_t parent, int level) {
    MLT_CHECK_OP(task_count_ + node.count, <=, kTraversalStack);
    const int bottom = task_count_;
    for (int lane = 0; lane < node.count; ++lane) {
      const Range& range = node.children[lane];
      int place = task_count_++;
      for (; place > bottom && tasks_[place - 1].range.begin < range.begin; --place) {
        tasks_[place] = tasks_[place - 1];
      }
      tasks_[place] = {range, parent, lane, level};
    }
  }

  std::uint32_t write_leaf(const Range& range) {
    for (std::uint32_t i = range.begin; i < range.end; ++i) {
      storage_.order[i] = storage_.references[i].index | (i + 1 == range.end ? kLastOfLeaf : 0);
    }
    return kLeafBit | subtree_.size.blocks++;
  }

  const BvhStorage& storage_;
  Subtree& subtree_;
  // At most the siblings of each level wait.
  Task tasks_[kTraversalStack];
  int task_count_ = 0;
};

/// The nodes above the subtrees, which are opened in rounds until all subtrees are small.
class TopBuilder {
 public:
  TopBuilder(const BvhStorage& storage, const UnitRunner& runner)
      : storage_(storage),
        work_(*storage.workspace),
        runner_(runner),
        splitter_(storage.references, work_, runner),
        capacity_(static_cast<std::uint32_t>(max_bvh_subtrees(storage.references.size()))),
        wanted_(std::max(count_of(storage) / kParts, kSmallestSubtree)) {}

  /// Leaves the subtrees in the workspace, in the order of their references, and returns how many.
  std::uint32_t build(BvhSize& size) {
    Subtree root;
    root.range = splitter_.measured(0, count_of(storage_));
    work_.subtrees[0] = root;
    count_ = 1;
    while (open_round()) continue;
    std::sort(work_.subtrees, work_.subtrees + count_,
              [](const Subtree& a, const Subtree& b) { return a.range.begin < b.range.begin; });
    size = size_;
    return count_;
  }

 private:
  /// Subtrees are at most this part of all, where the shape of the tree allows.
  static constexpr std::uint32_t kParts = 64;
  static constexpr std::uint32_t kSmallestSubtree = 1024;
  /// A node with more references than this part of all is opened by all threads together.
  static constexpr std::uint32_t kSharedParts = 4;

  static std::uint32_t count_of(const BvhStorage& storage) {
    return static_cast<std::uint32_t>(storage.references.size());
  }

  bool open_round() {
    std::uint32_t chosen[BvhWorkspace::kMaxOpened];
    std::uint32_t chosen_count = 0;
    for (std::uint32_t i = 0; i < count_; ++i) {
      if (work_.subtrees[i].range.count() > wanted_) chosen[chosen_count++] = i;
    }
    if (chosen_count == 0 || count_ + chosen_count * (kNodeWidth - 1) > capacity_) return false;
    const std::uint32_t shared_from = count_of(storage_) / kSharedParts;
    for (std::uint32_t i = 0; i < chosen_count; ++i) {
      const Subtree& subtree = work_.subtrees[chosen[i]];
      if (subtree.range.count() <= shared_from) continue;
      open_node(subtree.range, subtree.level, work_.opened[i],
                [&](const Range& range) { return splitter_.split(range, subtree.level); });
    }
    runner_.run(chosen_count, [&](std::uint64_t i) {
      const Subtree& subtree = work_.subtrees[chosen[i]];
      if (subtree.range.count() > shared_from) return;
      open_node(subtree.range, subtree.level, work_.opened[i],
                [&](const Range& range) { return split_range(storage_.references, range, subtree.level); });
    });
    for (std::uint32_t i = 0; i < chosen_count; ++i) replace(chosen[i], work_.opened[i]);
    return true;
  }

  /// Makes the subtree a node, and its children subtrees.
  void replace(std::uint32_t index, const OpenedNode& opened) {
    const Subtree replaced = work_.subtrees[index];
    MLT_CHECK_OP(replaced.level, <, kMaxLevels);
    const std::uint32_t node = size_.nodes++;
    size_.levels = std::max(size_.levels, replaced.level + 1);
    if (replaced.level > 0) storage_.nodes[replaced.parent].children[replaced.lane] = node;
    write_node(storage_.nodes[node], opened);
    for (int lane = 0; lane < opened.count; ++lane) {
      Subtree& child = work_.subtrees[lane == 0 ? index : count_++];
      child = Subtree{};
      child.range = opened.children[lane];
      child.parent = node;
      child.lane = lane;
      child.level = replaced.level + 1;
    }
  }

  const BvhStorage& storage_;
  BvhWorkspace& work_;
  const UnitRunner& runner_;
  SharedSplitter splitter_;
  std::uint32_t capacity_;
  std::uint32_t wanted_;
  std::uint32_t count_ = 0;
  BvhSize size_;
};

/// Gives the subtrees the nodes behind the first `nodes`.
void place_subtrees(std::span<Subtree> subtrees, std::uint32_t nodes, std::size_t capacity) {
  std::uint64_t next = nodes;
  for (Subtree& subtree : subtrees) {
    subtree.first_node = static_cast<std::uint32_t>(next);
    const std::uint32_t count = subtree.range.count();
    if (subtree.level == 0 || count > kLeafSize) next += max_bvh_nodes(count);
  }
  MLT_CHECK_OP(next, <=, capacity);
}

/// Numbers the leaves and enters the subtrees in the nodes above them.
void join_subtrees(std::span<Subtree> subtrees, std::span<BvhNode> nodes, BvhSize& size) {
  for (Subtree& subtree : subtrees) {
    subtree.first_block = size.blocks;
    size.blocks += subtree.size.blocks;
    size.nodes += subtree.size.nodes;
    size.levels = std::max(size.levels, subtree.size.levels);
    if (subtree.level == 0) continue;
    nodes[subtree.parent].children[subtree.lane] =
        subtree.size.nodes == 0 ? kLeafBit | subtree.first_block : subtree.first_node;
  }
}

void finish_subtree(const BvhStorage& storage, const Subtree& subtree, const LeafWriter& leaves) {
  for (BvhNode& node : storage.nodes.subspan(subtree.first_node, subtree.size.nodes)) {
    for (std::uint32_t& child : node.children) {
      if ((child & kLeafBit) != 0) child += subtree.first_block;
    }
  }
  leaves.write(leaves.context, subtree.first_block,
               storage.order.subspan(subtree.range.begin, subtree.range.count()));
}

}  // namespace

BvhSize build_bvh(const BvhStorage& storage, const LeafWriter& leaves, const UnitRunner& runner) {
  const std::size_t count = storage.references.size();
  MLT_CHECK_OP(count, <=, kMaxBvhPrimitives);
  MLT_CHECK_OP(storage.order.size(), ==, count);
  MLT_CHECK_OP(storage.nodes.size(), >=, bvh_node_capacity(count));
  BvhSize size;
  Subtree whole;
  std::span<Subtree> subtrees(&whole, 1);
  if (count >= kSharedCount) {
    MLT_CHECK(storage.workspace != nullptr);
    subtrees = {storage.workspace->subtrees, TopBuilder(storage, runner).build(size)};
  } else {
    whole.range = measured(storage.references, 0, static_cast<std::uint32_t>(count));
  }
  place_subtrees(subtrees, size.nodes, storage.nodes.size());
  runner.run(subtrees.size(), [&](std::uint64_t i) { SubtreeBuilder(storage, subtrees[i]).build(); });
  join_subtrees(subtrees, storage.nodes, size);
  runner.run(subtrees.size(), [&](std::uint64_t i) { finish_subtree(storage, subtrees[i], leaves); });
  return size;
}

}  // namespace mlt
