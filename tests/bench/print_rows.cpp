#include <fmt/format.h>

#include "core/formats/model_reader.hpp"
#include "core/layers/layers.hpp"
#include "tests/bench/bench.hpp"
#include "tests/bench/peers.hpp"
#include "tests/bench/process.hpp"
#include "tests/bench/stopwatch.hpp"
#include "tests/temporary_folder.hpp"

namespace contourd::bench {
namespace {

// The liver, 157 by 165 mm, at true scale: 1080 pixels of 160 um are 172.8 mm.
constexpr double kPitchUm = 160;
const DisplayGeometry kLiverDisplay{Pixels{1920}, Pixels{1080}, Micrometers{kPitchUm}};

Row masks_in_memory(const Bench& bench, const std::filesystem::path& file) {
  std::int32_t masks = 0;
  const Times times = time_runs(bench.runs(5), [&] {
    HeightIndex model(read_model_file(file).facets);
    const PixelMap map = PixelMap::true_scale(kLiverDisplay, model.bounds().center());
    const LayerStack layers = layers_for(Millimeters{model.bounds().size_z()}, kThinLayer);
    ContourEngine engine(std::move(model), EngineSettings{kLiverDisplay, AntiAliasing::On}, {map});
    const std::int32_t step = bench.quick ? 300 : 1;
    masks = 0;
    for (std::int32_t layer = 0; layer < layers.count; layer += step, ++masks)
      (void)engine.mask_at(layers.middle_of(layer));
  });
  Row row{"masks-liver", fmt::format("liver, file to {} grey masks 1920x1080 in memory", masks), "s"};
  row.figure = best(times.wall_s);
  row.cpu = best(times.cpu_s);
  row.target = Target{Target::Kind::AtMost, 0.4};
  row.note = fmt::format("{:.1f} us of CPU a mask, one thread", *row.cpu * 1e6 / masks);
  return row;
}

Row masks_as_files(const Bench& bench, const std::filesystem::path& file) {
  Row row{"png-liver", "liver, file to all masks as PNG files, all cores", "s"};
  const std::filesystem::path contourctl = this_program().parent_path() / "contourctl";
  if (!std::filesystem::exists(contourctl)) {
    row.skipped = "no contourctl beside this program";
    return row;
  }
  // The layers of a quick run are 10 mm thick: 20 files.
  const Nanometers layer = bench.quick ? Nanometers{10'000'000} : kThinLayer;
  std::vector<double> wall, cpu;
  for (int run = 0; run < bench.runs(2); ++run) {
    const testing::TemporaryFolder folder;
    const ProcessResult result =
        run_process({contourctl.string(), "slice", file.string(), "--layer-height-um",
                     fmt::format("{}", layer.count() / 1000), "--display", "1920x1080", "--pixel-pitch-um",
                     fmt::format("{}", kPitchUm), "--masks", folder.path().string()});
    wall.push_back(result.wall_s);
    cpu.push_back(result.cpu_s);
  }
  row.figure = best(wall);
  row.cpu = best(cpu);
  row.target = Target{Target::Kind::TimesFirstPeer, 8};
  if (bench.peers) {
    if (const auto peer = run_prusa_slicer(file, layer, kLiverDisplay)) row.peers.push_back(*peer);
  }
  return row;
}

}  // namespace

std::vector<Row> print_rows(const Bench& bench) {
  const auto file = bench.models.shared(kLiver);
  if (!file) return skipped_rows({"masks-liver", "png-liver"}, kLiver);
  return {masks_in_memory(bench, *file), masks_as_files(bench, *file)};
}

}  // namespace contourd::bench
