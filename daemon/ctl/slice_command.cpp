#include <fmt/format.h>

#include <chrono>
#include <memory>
#include <nlohmann/json.hpp>
#include <system_error>

#include "core/contour_engine.hpp"
#include "core/filled_area.hpp"
#include "core/layer_statistics.hpp"
#include "core/print_layers.hpp"
#include "core/stl_reader.hpp"
#include "daemon/ctl/commands.hpp"
#include "daemon/ctl/exit_codes.hpp"
#include "daemon/ctl/mask_files.hpp"
#include "daemon/ctl/slice_files.hpp"
#include "daemon/ctl/statistics_text.hpp"
#include "hw/png_file.hpp"

namespace contourd::ctl {
namespace {

using Json = nlohmann::ordered_json;
using SteadyClock = std::chrono::steady_clock;

double ms_between(SteadyClock::time_point from, SteadyClock::time_point to) {
  return std::chrono::duration<double, std::milli>(to - from).count();
}

PixelMap map_for(const SliceOptions& options, const Bounds& bounds) {
  return options.fit ? PixelMap::fit(options.engine.display, bounds)
                     : PixelMap::true_scale(options.engine.display, bounds.center());
}

ContourEngine engine_for(std::shared_ptr<const HeightIndex> model, const SliceOptions& options) {
  const PixelMap map = map_for(options, model->bounds());
  return ContourEngine({PlateModel{std::move(model), {map}}}, options.engine);
}

Mask read_lamp(const std::filesystem::path& path, const DisplayGeometry& display) {
  Mask lamp;
  try {
    lamp = read_png(path);
  } catch (const std::system_error&) {
    throw;
  } catch (const std::runtime_error& error) {
    throw UsageError(fmt::format("--lamp-mask {}: {}", path.string(), error.what()));
  }
  if (lamp.width() == display.width && lamp.height() == display.height) return lamp;
  throw UsageError(fmt::format("--lamp-mask {}: the picture is {}x{} pixels, the display {}x{}",
                               path.string(), lamp.width().count(), lamp.height().count(),
                               display.width.count(), display.height.count()));
}

void make_folder(const std::filesystem::path& folder) {
  std::error_code code;
  std::filesystem::create_directories(folder, code);
  if (code) throw OutputError(fmt::format("cannot make the folder {}: {}", folder.string(), code.message()));
}

void warn_if_larger_than_display(const SliceOptions& options, const Bounds& bounds) {
  const double width = options.engine.display.width_mm(), height = options.engine.display.height_mm();
  if (options.fit || (bounds.size_x() <= width && bounds.size_y() <= height)) return;
  fmt::print(
      stderr,
      "contourctl: warning: the model ({:.6g} x {:.6g} mm) is larger than the display ({:.6g} x {:.6g} mm); "
      "the masks are cut off\n",
      bounds.size_x(), bounds.size_y(), width, height);
}

int slice_at_height(const SliceOptions& options, const std::shared_ptr<const HeightIndex>& model) {
  const double z = options.z->count();
  Section section;
  slice_at(*model, z, section);
  Contours contours;
  ContourLinker().link(section.segments, to_millimeters(options.engine.display.pixel_pitch), contours);
  const double area = filled_area_mm2(contours);
  const double perimeter = perimeter_mm(contours);
  if (options.mask) {
    warn_if_larger_than_display(options, model->bounds());
    write_mask(*options.mask, engine_for(model, options).mask_at_z(*options.z));
  }
  if (options.json) {
    const Json json{{"z_mm", z},
                    {"intersecting_facets", section.intersecting_facets},
                    {"segments", section.segments.size()},
                    {"contours", contours.closed_loops()},
                    {"open_chains", contours.cracks.open_chains},
                    {"turned_chains", contours.cracks.turned_chains},
                    {"gaps_closed", contours.cracks.gaps_closed},
                    {"widest_gap_mm", contours.cracks.widest_gap.count()},
                    {"area_mm2", area},
                    {"perimeter_mm", perimeter}};
    fmt::print("{}\n", json.dump(2));
    return kOk;
  }
  fmt::print("z            {:.6g} mm\nsegments     {}\ncontours     {}\n", z, section.segments.size(),
             contours.closed_loops());
  fmt::print("open chains  {}\nturned       {}\ngaps closed  {}, the widest {:.6g} mm\n",
             contours.cracks.open_chains, contours.cracks.turned_chains, contours.cracks.gaps_closed,
             contours.cracks.widest_gap.count());
  fmt::print("area         {:.6g} mm2\nperimeter    {:.6g} mm\n", area, perimeter);
  return kOk;
}

// Where each layer is cut, above the model's lowest point: at its middle.
std::vector<Nanometers> layer_middles(const SliceOptions& options,
                                      const std::shared_ptr<const HeightIndex>& model) {
  const PrintLayers layers =
      options.adaptive
          ? PrintLayers({model}, *options.adaptive)
          : PrintLayers(layers_for(Millimeters{model->bounds().size_z()}, *options.layer_height));
  return middles_of(layers.all());
}

// The thesis's loop of section 3.5: slice, then join, each timed.
std::vector<LayerMeasurement> measure_layers(const SliceOptions& options, const HeightIndex& model,
                                             std::span<const Nanometers> layers) {
  const PixelMap map = map_for(options, model.bounds());
  const Millimeters tolerance = to_millimeters(options.engine.display.pixel_pitch);
  Section section;
  ContourLinker linker;
  Contours contours;
  std::vector<LayerMeasurement> measurements;
  measurements.reserve(layers.size());
  for (const Nanometers middle : layers) {
    const double z = model.bounds().min_z + to_millimeters(middle).count();
    const auto start = SteadyClock::now();
    slice_at(model, z, section);
    const auto sliced = SteadyClock::now();
    linker.link(section.segments, tolerance, contours);
    const auto joined = SteadyClock::now();
    measurements.push_back({Millimeters{z}, ms_between(start, sliced), ms_between(sliced, joined),
                            section.intersecting_facets, static_cast<std::uint32_t>(contours.loops.size())});
    if (options.contours) {
      write_contours(*options.contours / fmt::format("{:04}.csv", measurements.size()), contours, map);
    }
  }
  return measurements;
}

void report_measurements(const SliceOptions& options, std::size_t facets,
                         const std::vector<LayerMeasurement>& measurements) {
  const LayerStatistics statistics = statistics_of(measurements);
  if (options.csv) {
    write_measurements(*options.csv, measurements);
    std::filesystem::path summary = *options.csv;
    summary.replace_filename(options.csv->stem().string() + "-summary.csv");
    write_statistics(summary, statistics);
  }
  if (!options.json) {
    fmt::print("facets {}, layers {}\n\n", facets, measurements.size());
    return print_statistics(statistics);
  }
  Json json{{"facets", facets}, {"layers", measurements.size()}};
  json.update(statistics_json(statistics));
  fmt::print("{}\n", json.dump(2));
}

int slice_layers(const SliceOptions& options, const std::shared_ptr<const HeightIndex>& model) {
  const std::vector<Nanometers> layers = layer_middles(options, model);
  if (layers.empty()) {
    throw StlError(fmt::format("{}: the model is {:.6g} mm high, too thin for a layer",
                               options.model.string(), model->bounds().size_z()));
  }
  for (const auto& folder : {options.masks, options.contours}) {
    if (folder) make_folder(*folder);
  }
  // Masks alone ask for no measurement; anything else is measured.
  if (options.csv || options.contours || !options.masks) {
    report_measurements(options, model->facets().size(), measure_layers(options, *model, layers));
  }
  if (options.masks) {
    warn_if_larger_than_display(options, model->bounds());
    write_masks(*options.masks, layers, [&] { return engine_for(model, options); });
  }
  return kOk;
}

}  // namespace

int slice(SliceOptions options) {
  if (options.lamp) options.engine.lamp = read_lamp(*options.lamp, options.engine.display);
  const auto model = std::make_shared<const HeightIndex>(read_model(options.model).facets);
  if (model->turned_outwards()) fmt::print(stderr, "contourctl: warning: {}\n", kTurnedOutwardsWarning);
  return options.z ? slice_at_height(options, model) : slice_layers(options, model);
}

}  // namespace contourd::ctl
