// libFuzzer harness of the reader of convergence summaries: any bytes give a summary that can be written,
// plotted and put on a page, or an error.
#include <cstddef>
#include <cstdint>
#include <string>

#include "base/error.hpp"
#include "converge/report.hpp"
#include "fuzz/fuzz.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  try {
    mlt::ReportEntry entry;
    entry.summary = mlt::summary_from_json(std::string(reinterpret_cast<const char*>(data), size), "fuzz");
    // What was read is written in the one form that reading gives back.
    const std::string text = mlt::to_json(entry.summary);
    require(mlt::to_json(mlt::summary_from_json(text, "again")) == text);
    require(!mlt::to_text(entry.summary).empty());
    require(mlt::report_page({entry}).ends_with("</html>\n"));
  } catch (const mlt::InputError& error) {
    require(!error.diagnostics().empty());
  }
  return 0;
}
