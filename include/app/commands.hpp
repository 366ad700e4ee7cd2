// The commands themselves. Each returns the process's exit code or throws InputError or ResourceError.
#pragma once

#include "app/command_line.hpp"
#include "base/error.hpp"

namespace mlt {

/// Checks that every output can be written, reads the scene, renders, writes the outputs. When one output
/// fails in the end, the others are still written.
ExitCode run_render(const RenderCommand& command);

/// Prints what the scene contains, the features found and skipped, and the memory plan, without rendering.
ExitCode run_info(const InfoCommand& command);

/// Prints the metrics of a pair of images or of all pairs of two folders, and writes the pictures asked for;
/// kCompareFailed when a metric is beyond its limit, or when --test rejects.
ExitCode run_compare(const CompareCommand& command);

/// The part of run_compare behind --test.
ExitCode run_replicate_test(const CompareCommand& command);

/// Renders the plan of `command` and writes its results into the folder, the summary last.
ExitCode run_converge(const ConvergeCommand& command);

/// Writes one page with every result of run_converge in the folder and its subfolders.
ExitCode run_report(const ReportCommand& command);

/// Runs the whole program: parses `words` (without the program's name), runs the command, and turns every
/// error into a message on standard error and an exit code.
ExitCode run_program(const std::vector<std::string>& words);

}  // namespace mlt
