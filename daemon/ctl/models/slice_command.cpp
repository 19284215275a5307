#include "daemon/ctl/models/slice_command.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <memory>
#include <nlohmann/json.hpp>
#include <system_error>
#include <utility>
#include <vector>

#include "core/contour/filled_area.hpp"
#include "core/engine/contour_engine.hpp"
#include "core/formats/model_reader.hpp"
#include "core/layers/layer_statistics.hpp"
#include "core/layers/print_layers.hpp"
#include "daemon/ctl/models/layer_folder.hpp"
#include "daemon/ctl/models/mask_files.hpp"
#include "daemon/ctl/models/read_model.hpp"
#include "daemon/ctl/models/slice_files.hpp"
#include "daemon/ctl/models/statistics_text.hpp"
#include "daemon/ctl/models/supported_model.hpp"
#include "daemon/ctl/models/turned_facets.hpp"
#include "daemon/ctl/terminal/exit_codes.hpp"
#include "daemon/prepare/mesh_repair_text.hpp"
#include "daemon/prepare/supports_text.hpp"
#include "daemon/system/readable.hpp"
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

SupportedModel stand(const std::shared_ptr<const HeightIndex>& model, const SliceOptions& options) {
  if (!options.supports) return lay_on_plate(model, map_for(options, model->bounds()));
  SupportingOptions supporting{.display = options.engine.display};
  if (options.layer_height) supporting.layer = *options.layer_height;
  if (options.adaptive) supporting.layer = options.adaptive->thickest;
  return support_model(model, supporting);
}

Mask read_uniformity_mask(const std::filesystem::path& path, const DisplayGeometry& display) {
  Mask mask;
  try {
    mask = read_png(path);
  } catch (const std::system_error&) {
    throw;
  } catch (const std::runtime_error& error) {
    throw UsageError(fmt::format("--uniformity-mask {}: {}", path.string(), error.what()));
  }
  if (mask.width() == display.width && mask.height() == display.height) return mask;
  throw UsageError(fmt::format("--uniformity-mask {}: the picture is {}x{} pixels, the display {}x{}",
                               path.string(), mask.width().count(), mask.height().count(),
                               display.width.count(), display.height.count()));
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

void warn_if_beside_model(Millimeters z, const Bounds& bounds) {
  if (bounds.empty() || (z.count() >= bounds.min_z && z.count() <= bounds.max_z)) return;
  fmt::print(
      stderr,
      "contourctl: warning: z is {:.6g} mm, but the model is from {:.6g} to {:.6g} mm: nothing is cut\n",
      z.count(), bounds.min_z, bounds.max_z);
}

Json cracks_json(const LayerCracks& cracks) {
  return {{"open_chains", cracks.open_chains},
          {"turned_chains", cracks.turned_chains},
          {"gaps_closed", cracks.gaps_closed},
          {"widest_gap_mm", cracks.widest_gap.count()}};
}

// Adds the supports of the whole print, if there are any.
void add_supports(const SupportedModel& supported, Json& json) {
  if (supported.supports) json["supports"] = supports_summary_json(counts_of(*supported.supports));
}
void print_supports(const SupportedModel& supported) {
  if (supported.supports) fmt::print("supports     {}\n", supports_line(counts_of(*supported.supports)));
}

int slice_at_height(const SliceOptions& options, const SupportedModel& supported) {
  const std::shared_ptr<const HeightIndex>& model = supported.model.model;
  const Millimeters z = *options.z;
  if (!supported.supports) warn_if_beside_model(z, model->bounds());
  Section section;
  slice_at(*model, z, section);
  Contours contours;
  ContourLinker().link(section.segments, to_millimeters(options.engine.display.pixel_pitch), contours);
  const double area = filled_area_mm2(contours);
  const double perimeter = perimeter_mm(contours);
  if (options.mask) {
    warn_if_larger_than_display(options, model->bounds());
    write_mask(*options.mask, supported.engine(options.engine).mask_at_z(z));
  }
  if (options.json) {
    Json json{{"z_mm", z.count()},
              {"intersecting_facets", section.intersecting_facets},
              {"segments", section.segments.size()},
              {"contours", contours.closed_loops()}};
    json.update(cracks_json(contours.cracks));
    json["area_mm2"] = area;
    json["perimeter_mm"] = perimeter;
    add_supports(supported, json);
    fmt::print("{}\n", json.dump(2));
    return kOk;
  }
  fmt::print("z            {:.6g} mm\nsegments     {}\ncontours     {}\n", z.count(), section.segments.size(),
             contours.closed_loops());
  fmt::print("open chains  {}\nturned       {}\ngaps closed  {}, the widest {:.6g} mm\n",
             contours.cracks.open_chains, contours.cracks.turned_chains, contours.cracks.gaps_closed,
             contours.cracks.widest_gap.count());
  fmt::print("area         {:.6g} mm2\nperimeter    {:.6g} mm\n", area, perimeter);
  print_supports(supported);
  return kOk;
}

// Returns the heights above the plate at which the layers are cut: their middles.
std::vector<Nanometers> layer_middles(const SliceOptions& options, const StandingModel& model) {
  const PrintLayers layers = options.adaptive ? PrintLayers({model}, *options.adaptive)
                                              : PrintLayers(layers_for(model.top(), *options.layer_height));
  return middles_of(layers.all());
}

struct MeasuredLayers {
  std::vector<LayerMeasurement> measurements;
  std::vector<LayerCracks> cracks;
};

// Times slicing and joining of each layer (thesis, section 3.5).
MeasuredLayers measure_layers(const SliceOptions& options, const StandingModel& model,
                              std::span<const Nanometers> layers) {
  const PixelMap map = map_for(options, model.model->bounds());
  const Millimeters tolerance = to_millimeters(options.engine.display.pixel_pitch);
  Section section;
  ContourLinker linker;
  Contours contours;
  MeasuredLayers measured;
  measured.measurements.reserve(layers.size());
  measured.cracks.reserve(layers.size());
  for (const Nanometers middle : layers) {
    const Millimeters z = model.z_at(middle);
    const auto start = SteadyClock::now();
    slice_at(*model.model, z, section);
    const auto sliced = SteadyClock::now();
    linker.link(section.segments, tolerance, contours);
    const auto joined = SteadyClock::now();
    measured.measurements.push_back({z, ms_between(start, sliced), ms_between(sliced, joined),
                                     section.intersecting_facets,
                                     static_cast<std::uint32_t>(contours.loops.size())});
    measured.cracks.push_back(contours.cracks);
    if (options.contours) {
      write_contours(*options.contours / layer_file(measured.cracks.size(), ".csv"), contours, map);
    }
  }
  return measured;
}

LayerCracks total_of(std::span<const LayerCracks> layers) {
  LayerCracks total;
  for (const LayerCracks& cracks : layers)
    total += cracks;
  return total;
}

void warn_if_cracked(std::span<const LayerCracks> layers) {
  const auto sound = std::ranges::count(layers, LayerCracks{});
  const auto cracked = layers.size() - static_cast<std::size_t>(sound);
  if (cracked == 0) return;
  const LayerCracks total = total_of(layers);
  fmt::print(
      stderr,
      "contourctl: warning: the model is cracked in {} of {} layers: {} open chains, {} turned, {} gaps "
      "closed, the widest {:.6g} mm\n",
      cracked, layers.size(), total.open_chains, total.turned_chains, total.gaps_closed,
      total.widest_gap.count());
}

Json cracked_layers_json(std::span<const LayerCracks> layers) {
  Json list = Json::array();
  for (std::size_t i = 0; i < layers.size(); ++i) {
    if (layers[i] == LayerCracks{}) continue;
    list.push_back({{"layer", i + 1}});
    list.back().update(cracks_json(layers[i]));
  }
  return list;
}

void report_measurements(const SliceOptions& options, const SupportedModel& supported,
                         const MeasuredLayers& measured) {
  const std::size_t facets = supported.model.model->facets().size();
  const auto& measurements = measured.measurements;
  const LayerStatistics statistics = statistics_of(measurements);
  if (options.csv) {
    write_measurements(*options.csv, measurements);
    std::filesystem::path summary = *options.csv;
    summary.replace_filename(options.csv->stem().string() + "-summary.csv");
    write_statistics(summary, statistics);
  }
  if (!options.json) {
    fmt::print("facets {}, layers {}\n", facets, measurements.size());
    print_supports(supported);
    fmt::print("\n");
    return print_statistics(statistics);
  }
  Json json{{"facets", facets}, {"layers", measurements.size()}};
  json.update(statistics_json(statistics));
  json.update(cracks_json(total_of(measured.cracks)));
  json["cracked_layer_list"] = cracked_layers_json(measured.cracks);
  add_supports(supported, json);
  fmt::print("{}\n", json.dump(2));
}

int slice_layers(const SliceOptions& options, const SupportedModel& supported) {
  const StandingModel& standing = supported.model;
  const std::shared_ptr<const HeightIndex>& model = standing.model;
  const std::vector<Nanometers> layers = layer_middles(options, standing);
  if (layers.empty()) {
    throw ModelError(fmt::format("{}: the model is {:.6g} mm high, too thin for a layer",
                                 options.model.string(), model->bounds().size_z()));
  }
  const Earlier earlier = options.force ? Earlier::Replace : Earlier::Refuse;
  if (options.masks) open_layer_folder(*options.masks, ".png", earlier);
  if (options.contours) open_layer_folder(*options.contours, ".csv", earlier);
  // Layers are measured unless only masks are written.
  std::vector<LayerCracks> cracks;
  if (options.csv || options.contours || options.json || !options.masks) {
    MeasuredLayers measured = measure_layers(options, standing, layers);
    report_measurements(options, supported, measured);
    cracks = std::move(measured.cracks);
  }
  if (options.masks) {
    warn_if_larger_than_display(options, model->bounds());
    cracks = write_masks(*options.masks, layers, [&] { return supported.engine(options.engine); });
    if (!options.json)
      fmt::print("{} in {}\n", count_of(layers.size(), "mask", "masks"), options.masks->string());
  }
  warn_if_cracked(cracks);
  return kOk;
}

}  // namespace

int slice(SliceOptions options) {
  if (options.uniformity)
    options.engine.uniformity = read_uniformity_mask(*options.uniformity, options.engine.display);
  std::vector<Facet> facets = read_model(options.model).facets;
  turn_facets(facets, options.up, options.scale.value_or(1));
  scale_facets(facets, options.scale);
  const auto model = std::make_shared<const HeightIndex>(std::move(facets));
  if (model->turned_outwards()) fmt::print(stderr, "contourctl: warning: {}\n", kTurnedOutwardsWarning);
  if (model->repairs() != MeshRepairs{})
    fmt::print(stderr, "contourctl: warning: {}\n", repair_warning(model->repairs()));
  const SupportedModel supported = stand(model, options);
  warn_of_unheld(supported);
  return options.z ? slice_at_height(options, supported) : slice_layers(options, supported);
}

}  // namespace contourd::ctl
