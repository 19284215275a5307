#include "tests/bench/peers.hpp"

#include <fmt/format.h>

#include "tests/bench/process.hpp"
#include "tests/temporary_folder.hpp"

namespace contourd::bench {

std::optional<Peer> run_slic3r(const std::filesystem::path& model, Nanometers layer) {
  const auto program = find_program("slic3r");
  if (!program) return std::nullopt;
  const testing::TemporaryFolder folder;
  const std::string layer_mm = fmt::format("{}", to_millimeters(layer).count());
  const ProcessResult result =
      run_process({program->string(), "--export-svg", "--layer-height", layer_mm, "--first-layer-height",
                   layer_mm, "-o", (folder.path() / "contours.svg").string(), model.string()});
  return Peer{"slic3r", result.wall_s, false, result.cpu_s};
}

std::optional<Peer> run_prusa_slicer(const std::filesystem::path& model, Nanometers layer,
                                     const DisplayGeometry& display) {
  const auto program = find_program("prusa-slicer");
  if (!program) return std::nullopt;
  const testing::TemporaryFolder folder;
  const std::string layer_mm = fmt::format("{}", to_millimeters(layer).count());
  const double pitch_mm = to_millimeters(display.pixel_pitch).count();
  const double width_mm = display.width.count() * pitch_mm, height_mm = display.height.count() * pitch_mm;
  const ProcessResult result = run_process({program->string(),
                                            "--export-sla",
                                            "--printer-technology",
                                            "SLA",
                                            "--no-supports-enable",
                                            "--no-pad-enable",
                                            "--layer-height",
                                            layer_mm,
                                            "--initial-layer-height",
                                            layer_mm,
                                            "--faded-layers",
                                            "3",
                                            "--display-width",
                                            fmt::format("{}", width_mm),
                                            "--display-height",
                                            fmt::format("{}", height_mm),
                                            "--display-pixels-x",
                                            fmt::format("{}", display.width.count()),
                                            "--display-pixels-y",
                                            fmt::format("{}", display.height.count()),
                                            "--display-orientation",
                                            "landscape",
                                            "--bed-shape",
                                            fmt::format("0x0,{0}x0,{0}x{1},0x{1}", width_mm, height_mm),
                                            "--max-print-height",
                                            "1000",
                                            "--dont-arrange",
                                            "--center",
                                            fmt::format("{},{}", width_mm / 2, height_mm / 2),
                                            "--output",
                                            (folder.path() / "masks.sl1").string(),
                                            model.string()});
  return Peer{"prusa-slicer", result.wall_s, false, result.cpu_s};
}

}  // namespace contourd::bench
