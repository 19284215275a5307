#include "tests/bench/peers.hpp"

#include <fmt/format.h>

#include <cstdio>
#include <stdexcept>
#include <string>
#include <vector>

#include "tests/bench/process.hpp"
#include "tests/temporary_folder.hpp"

namespace contourd::bench {
namespace {

using Words = std::vector<std::string>;

// Returns nullopt if the program is not installed. A program that fails is skipped too; our figures are still
// useful.
std::optional<Peer> measured(const std::string& name, const Words& options) {
  const auto program = find_program(name);
  if (!program) return std::nullopt;
  Words command{program->string()};
  command.insert(command.end(), options.begin(), options.end());
  try {
    const ProcessResult result = run_process(command);
    return Peer{name, result.wall_s, false, result.cpu_s};
  } catch (const std::runtime_error& error) {
    fmt::print(stderr, "contourd-bench: {} is skipped: {}\n", name, error.what());
    return std::nullopt;
  }
}

std::string words_of(double number) {
  return fmt::format("{}", number);
}

Words words_of(const DisplayGeometry& display) {
  const double pitch_mm = to_millimeters(display.pixel_pitch).count();
  const double width_mm = display.width.count() * pitch_mm, height_mm = display.height.count() * pitch_mm;
  return {"--display-width",
          words_of(width_mm),
          "--display-height",
          words_of(height_mm),
          "--display-pixels-x",
          words_of(display.width.count()),
          "--display-pixels-y",
          words_of(display.height.count()),
          "--display-orientation",
          "landscape",
          "--bed-shape",
          fmt::format("0x0,{0}x0,{0}x{1},0x{1}", width_mm, height_mm),
          "--center",
          fmt::format("{},{}", width_mm / 2, height_mm / 2)};
}

}  // namespace

std::optional<Peer> run_slic3r(const std::filesystem::path& model, Nanometers layer) {
  const testing::TemporaryFolder folder;
  const std::string layer_mm = words_of(to_millimeters(layer).count());
  return measured("slic3r", {"--export-svg", "--layer-height", layer_mm, "--first-layer-height", layer_mm,
                             "-o", (folder.path() / "contours.svg").string(), model.string()});
}

std::optional<Peer> run_prusa_slicer(const std::filesystem::path& model, Nanometers layer,
                                     const DisplayGeometry& display) {
  const testing::TemporaryFolder folder;
  const std::string layer_mm = words_of(to_millimeters(layer).count());
  Words words{"--export-sla",
              "--printer-technology",
              "SLA",
              "--no-supports-enable",
              "--no-pad-enable",
              "--dont-arrange",
              "--layer-height",
              layer_mm,
              "--initial-layer-height",
              layer_mm,
              "--faded-layers",
              "3",
              "--max-print-height",
              "1000"};
  const Words shape = words_of(display);
  words.insert(words.end(), shape.begin(), shape.end());
  words.insert(words.end(), {"--output", (folder.path() / "masks.sl1").string(), model.string()});
  return measured("prusa-slicer", words);
}

}  // namespace contourd::bench
