#include <fmt/format.h>

#include "core/formats/model_reader.hpp"
#include "tests/bench/bench.hpp"
#include "tests/bench/peers.hpp"
#include "tests/bench/process.hpp"
#include "tests/bench/stopwatch.hpp"

namespace contourd::bench {
namespace {

// The gyroid ball, 40 mm, at true scale.
const DisplayGeometry kGyroidDisplay{Pixels{1920}, Pixels{1080}, Micrometers{40}};
constexpr Nanometers kGyroidLayer{50'000};

double megabytes(const std::filesystem::path& file) {
  return static_cast<double>(std::filesystem::file_size(file)) / 1e6;
}

// Makes the mask in the middle of the model: one at the bottom would be almost empty.
void first_mask(HeightIndex model) {
  const double middle = model.bounds().min_z + model.bounds().size_z() / 2;
  const PixelMap map = PixelMap::fit(kGyroidDisplay, model.bounds());
  ContourEngine engine(std::move(model), EngineSettings{kGyroidDisplay, AntiAliasing::On}, {map});
  (void)engine.mask_at_z(Millimeters{middle});
}

Row first_mask_row(const Bench& bench) {
  const std::filesystem::path file = bench.models.gyroid();
  std::size_t facets = 0;
  Times whole, reading, indexing, mask;
  const auto load = [&] {
    Model model;
    HeightIndex index;
    time_once(reading, [&] { model = read_model_file(file); });
    facets = model.facets.size();
    time_once(indexing, [&] { index = HeightIndex(std::move(model.facets)); });
    time_once(mask, [&] { first_mask(std::move(index)); });
  };
  load();  // brings the file into the page cache
  for (int run = 0; run < bench.runs(11); ++run)
    time_once(whole, load);
  Row row{"first-mask", fmt::format("file of {} facets ({:.0f} MB) to first mask", facets, megabytes(file)),
          "ms"};
  row.figure = best(whole.wall_s) * 1e3;
  row.cpu = best(whole.cpu_s) * 1e3;
  row.target = Target{Target::Kind::AtMost, 120};
  row.note = fmt::format("reading {:.1f}, indexing {:.1f}, engine and mask {:.1f} ms; reading at {:.0f} MB/s",
                         best(reading.wall_s) * 1e3, best(indexing.wall_s) * 1e3, best(mask.wall_s) * 1e3,
                         megabytes(file) / best(reading.wall_s));
  if (bench.peers) {
    if (auto peer = run_prusa_slicer(file, kGyroidLayer, kGyroidDisplay)) {
      row.peers.push_back({peer->name + " (all masks: it has none before)", peer->figure * 1e3, false,
                           peer->cpu.value() * 1e3});
    }
  }
  return row;
}

Row ascii_row(const Bench& bench) {
  const std::filesystem::path file = bench.models.ascii_gyroid();
  const Times times = time_runs(bench.runs(7), [&] { (void)read_model_file(file); });
  Row row{"ascii", fmt::format("reading ASCII ({:.0f} MB)", megabytes(file)), "MB/s"};
  row.figure = megabytes(file) / best(times.wall_s);
  row.cpu = megabytes(file) / best(times.cpu_s);
  row.target = Target{Target::Kind::AtLeast, 250};
  return row;
}

Row memory_row(const std::string& id, const std::string& name, const std::filesystem::path& file) {
  const ProcessResult child = run_process({this_program().string(), "--memory-of", file.string()});
  Row row{id, fmt::format("{} ({:.0f} MB), peak memory to first mask", name, megabytes(file)), "MB"};
  row.figure = std::stod(child.output) / 1e6;
  row.target = Target{Target::Kind::AtMost, 1.4 * megabytes(file) + 24};
  row.note = fmt::format("the whole process; {:.2f} x the file", row.figure / megabytes(file));
  return row;
}

}  // namespace

void print_memory_of_first_mask(const std::filesystem::path& model) {
  first_mask(HeightIndex(read_model_file(model).facets));
  fmt::print("{}\n", peak_memory_bytes());
}

std::vector<Row> load_rows(const Bench& bench) {
  std::vector<Row> rows{first_mask_row(bench), ascii_row(bench),
                        memory_row("memory-gyroid", "gyroid", bench.models.gyroid())};
  rows.back().peers = {{"prusa-slicer, 58 MB", 327, true}, {"slic3r, 58 MB", 733, true}};
  const auto plate = bench.models.shared(kPlate);
  rows.push_back(plate ? memory_row("memory-plate", "plate", *plate)
                       : skipped_rows({"memory-plate"}, kPlate).front());
  return rows;
}

}  // namespace contourd::bench
