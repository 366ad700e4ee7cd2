#include <new>

#include "app/commands.hpp"
#include "app/console.hpp"

namespace mlt {
namespace {

ExitCode run_command(const Command& command) {
  return std::visit(
      [](const auto& chosen) -> ExitCode {
        using Kind = std::decay_t<decltype(chosen)>;
        if constexpr (std::is_same_v<Kind, RenderCommand>) {
          return run_render(chosen);
        } else if constexpr (std::is_same_v<Kind, InfoCommand>) {
          return run_info(chosen);
        } else if constexpr (std::is_same_v<Kind, CompareCommand>) {
          return run_compare(chosen);
        } else if constexpr (std::is_same_v<Kind, ConvergeCommand>) {
          return run_converge(chosen);
        } else if constexpr (std::is_same_v<Kind, ReportCommand>) {
          return run_report(chosen);
        } else {
          print_output(chosen.text);
          return ExitCode::kOk;
        }
      },
      command);
}

}  // namespace

ExitCode run_program(const std::vector<std::string>& words) {
  try {
    return run_command(parse_command_line(words));
  } catch (const InputError& error) {
    for (const Diagnostic& diagnostic : error.diagnostics()) {
      print_message((diagnostic.file == "mlt" || diagnostic.file.starts_with("mlt ") ? "" : "mlt: ") +
                    diagnostic.to_string() + "\n");
    }
    return ExitCode::kBadInput;
  } catch (const ResourceError& error) {
    print_message(std::string("mlt: ") + error.what() + "\n");
    return ExitCode::kResourceLimit;
  } catch (const std::bad_alloc&) {
    print_message("mlt: the system has not enough memory\n");
    return ExitCode::kResourceLimit;
  } catch (const std::exception& error) {
    print_message(std::string("mlt: bug: ") + error.what() + "\n");
    return ExitCode::kBug;
  }
}

}  // namespace mlt
