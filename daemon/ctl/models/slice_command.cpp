#include "daemon/ctl/models/model_commands.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "core/contour/filled_area.hpp"
#include "core/engine/contour_engine.hpp"
#include "core/layers/adaptive_layers.hpp"
#include "core/layers/layer_statistics.hpp"
#include "core/layers/print_layers.hpp"
#include "daemon/ctl/models/layer_files.hpp"
#include "daemon/ctl/models/layer_measurements.hpp"
#include "daemon/ctl/models/model_arguments.hpp"
#include "daemon/ctl/models/supported_model.hpp"
#include "daemon/ctl/terminal/exit_codes.hpp"
#include "daemon/prepare/job_supports.hpp"
#include "daemon/prepare/mesh_repair_text.hpp"
#include "daemon/prepare/print_findings.hpp"
#include "daemon/prepare/supports_text.hpp"
#include "daemon/system/readable.hpp"
#include "hw/png_file.hpp"

namespace contourd::ctl {
namespace {

struct SliceOptions {
  std::filesystem::path model;
  bool json = false;
  // Exactly one of these three is given: one height (in the file's coordinates), uniform layers, or adaptive
  // layers.
  std::optional<Millimeters> z;
  std::optional<Nanometers> layer_height;
  std::optional<AdaptiveLayers> adaptive;

  std::optional<UpOption> up;  // applied first; z then refers to the turned model

  EngineSettings engine;
  bool fit = false;
  SupportPolicy supports =
      SupportPolicy::Off;  // layers then count from the plate; z still refers to the file
  SizeArgs size;
  std::optional<std::filesystem::path> uniformity;  // picture to read into engine.uniformity

  std::optional<std::filesystem::path> mask;      // one PNG, with z
  std::optional<std::filesystem::path> masks;     // a folder of PNGs, with layers
  std::optional<std::filesystem::path> csv;       // with layers
  std::optional<std::filesystem::path> contours;  // a folder of CSVs, with layers
  bool force = false;                             // replace the files of an earlier slice in these folders
};

// Arguments as the user typed them, before they have units.
struct SliceArgs {
  SliceOptions options;
  std::optional<double> z_mm, layer_height_um, cusp_um;
  double min_layer_um = 25, max_layer_um = 100;
  DisplayArgs display;
  std::string supports = "off";
  double grow_um = 0, elephant_foot_um = 0, elephant_foot_height_um = 0, gamma = 1;
  int threshold = 0;
  std::optional<std::string> up;
};

// Parses the corrections of masks that a resin's and a printer's profile can set, too.
void parse_corrections(EngineSettings& engine, const SliceArgs& args) {
  const auto check = [](const char* name, double value, double least, double most) {
    // Negated, so that NaN is refused, too.
    if (!(value >= least && value <= most))
      throw UsageError(fmt::format("{} {}: expected {} to {}", name, value, least, most));
  };
  check("--grow-um", args.grow_um, -500, 500);
  check("--elephant-foot-um", args.elephant_foot_um, 0, 500);
  check("--elephant-foot-height-um", args.elephant_foot_height_um, 0, 10000);
  check("--gamma", args.gamma, 0.1, 10);
  check("--threshold", args.threshold, 0, 255);
  const auto foot_height = to_nanometers(to_millimeters(Micrometers{args.elephant_foot_height_um}));
  engine.compensation = {Micrometers{args.grow_um}, Micrometers{args.elephant_foot_um},
                         foot_height.value_or(Nanometers{})};
  engine.tone = {args.gamma, static_cast<std::uint8_t>(args.threshold)};
  if ((args.elephant_foot_um > 0) != (args.elephant_foot_height_um > 0))
    throw UsageError("--elephant-foot-um and --elephant-foot-height-um go together");
}

void check_corrections_go_with_masks(const SliceOptions& options) {
  const bool moves = options.engine.compensation != Compensation{};
  const bool corrects = moves || options.engine.tone != ToneCurve{} || options.uniformity;
  if (corrects && !options.mask && !options.masks) {
    throw UsageError(
        "--grow-um, --elephant-foot-um, --uniformity-mask, --gamma and --threshold change masks: they need "
        "--mask or --masks");
  }
  // With --fit, a micrometre of the part is not a micrometre of the picture.
  if (moves && options.fit) throw UsageError("--grow-um and --elephant-foot-um exclude --fit");
}

AdaptiveLayers parse_adaptive(const SliceArgs& args) {
  const AdaptiveLayers layers{parse_um("--min-layer-um", args.min_layer_um, 1),
                              parse_um("--max-layer-um", args.max_layer_um, 1),
                              parse_um("--cusp-um", *args.cusp_um, 0.1)};
  if (layers.thinnest > layers.thickest) {
    throw UsageError(fmt::format("--min-layer-um {} is more than --max-layer-um {}", args.min_layer_um,
                                 args.max_layer_um));
  }
  return layers;
}

SliceOptions parse_slice(const SliceArgs& args) {
  SliceOptions options = args.options;
  options.supports = support_policy(args.supports);
  (void)parse_size(options.size);
  // Supports have sizes in millimetres, and a picture that fills the display has no scale.
  if (options.supports != SupportPolicy::Off && options.fit)
    throw UsageError(fmt::format("--supports {} excludes --fit", args.supports));
  options.up = parse_up(args.up);
  options.engine.display = parse_display(args.display);
  options.engine.anti_aliasing = parse_anti_aliasing(args.display);
  parse_corrections(options.engine, args);
  refuse_to_overwrite_model(options.model, "--mask", options.mask);
  refuse_to_overwrite_model(options.model, "--csv", options.csv);
  if (int{args.z_mm.has_value()} + int{args.layer_height_um.has_value()} + int{args.cusp_um.has_value()} != 1)
    throw UsageError("slice needs exactly one of --z, --layer-height-um and --cusp-um");
  if (args.z_mm) {
    if (!std::isfinite(*args.z_mm))
      throw UsageError(fmt::format("--z {}: expected a finite number", *args.z_mm));
    options.z = Millimeters{*args.z_mm};
    if (options.masks || options.csv || options.contours)
      throw UsageError("--masks, --csv and --contours need --layer-height-um or --cusp-um");
  }
  if (options.force && !options.masks && !options.contours)
    throw UsageError("--force needs --masks or --contours");
  if (options.mask && !args.z_mm) throw UsageError("--mask needs --z");
  if (args.layer_height_um) options.layer_height = parse_um("--layer-height-um", *args.layer_height_um, 1);
  if (args.cusp_um) options.adaptive = parse_adaptive(args);
  check_corrections_go_with_masks(options);
  return options;
}

using Json = nlohmann::ordered_json;

PixelMap map_for(const SliceOptions& options, const Bounds& bounds) {
  return options.fit ? PixelMap::fit(options.engine.display, bounds)
                     : PixelMap::true_scale(options.engine.display, bounds.center());
}

SupportedModel stand(const std::shared_ptr<const HeightIndex>& model, const SliceOptions& options) {
  if (options.supports == SupportPolicy::Off) return lay_on_plate(model, map_for(options, model->bounds()));
  SupportingOptions supporting{.display = options.engine.display,
                               .adaptive = options.adaptive,
                               .compensation = options.engine.compensation,
                               .anti_aliasing = options.engine.anti_aliasing,
                               .threshold = options.engine.tone.threshold,
                               .policy = options.supports};
  if (options.layer_height) supporting.layer = *options.layer_height;
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
  fmt::print("area         {:.6g} mm²\nperimeter    {:.6g} mm\n", area, perimeter);
  print_supports(supported);
  return kOk;
}

// Returns the heights above the plate at which the layers are cut: their middles.
std::vector<Nanometers> layer_middles(const SliceOptions& options, const StandingModel& model) {
  return middles_of(print_layers(model, options.layer_height.value_or(Nanometers{}), options.adaptive).all());
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
  LayerStopwatch stopwatch;
  MeasuredLayers measured;
  for (const Nanometers middle : layers) {
    measured.measurements.push_back(stopwatch.measure(*model.model, model.z_at(middle), tolerance));
    const Contours& contours = stopwatch.contours();
    measured.cracks.push_back(contours.cracks);
    if (options.contours)
      write_contours(*options.contours / layer_file(measured.cracks.size(), ".csv"), contours, map);
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
    write_text(*options.csv, measurements_csv(measurements));
    std::filesystem::path summary = *options.csv;
    summary.replace_filename(options.csv->stem().string() + "-summary.csv");
    write_text(summary, statistics_csv(statistics));
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

int slice(SliceOptions options) {
  if (options.uniformity)
    options.engine.uniformity = read_uniformity_mask(*options.uniformity, options.engine.display);
  const auto model = std::make_shared<const HeightIndex>(
      read_turned_model(options.model, options.up, parse_size(options.size)).facets);
  for (const std::string& warning : mesh_warnings(model->turned_outwards(), model->repairs()))
    fmt::print(stderr, "contourctl: warning: {}\n", warning);
  const SupportedModel supported = stand(model, options);
  if (supported.own_supports != OwnSupports::None)
    fmt::print(stderr, "contourctl: warning: {}\n",
               own_supports_sentence("the model", supported.own_supports, "contourctl"));
  if (supported.supports) {
    if (const std::string sentence = unheld_sentence(supported.supports->unheld); !sentence.empty())
      fmt::print(stderr, "contourctl: warning: {}\n", sentence);
  }
  return options.z ? slice_at_height(options, supported) : slice_layers(options, supported);
}

}  // namespace

void add_slice(Command& program) {
  Command& command = program.add("slice", "Slice a model at one height or into layers");
  auto& args = command.arguments<SliceArgs>();
  SliceOptions& options = args.options;
  command.option("MODEL", options.model, "Model file").required().allow_empty();
  command.option("--z", args.z_mm, "Height of the cut, mm, in the file's coordinates");
  command.option("--up", args.up, kUpHelp).suggests(up_presets);
  command.option("--layer-height-um", args.layer_height_um, "Layer height, um");
  const Option& cusp = command.option("--cusp-um", args.cusp_um,
                                      "Adaptive layers: maximum distance of an edge from the surface, um");
  command.option("--min-layer-um", args.min_layer_um, "Thinnest adaptive layer, um").needs(cusp);
  command.option("--max-layer-um", args.max_layer_um, "Thickest adaptive layer, um").needs(cusp);
  command.option("--mask", options.mask, "Write the mask at --z to this PNG file");
  command.option("--masks", options.masks, "Write one PNG file per layer to this folder: 0001.png ...");
  command.option("--csv", options.csv, "Write layer measurements to this file, totals to FILE-summary.csv");
  command.option("--contours", options.contours,
                 "Write one CSV file of contour points per layer to this folder");
  add_display_options(command, args.display);
  command.option("--grow-um", args.grow_um, "Move the contours outwards, um; negative: inwards");
  command.option("--elephant-foot-um", args.elephant_foot_um, "Move the contours inwards at the bottom, um");
  command.option("--elephant-foot-height-um", args.elephant_foot_height_um,
                 "Height over which the elephant foot correction fades, um");
  command.option("--uniformity-mask", options.uniformity,
                 "Darken the masks by this 8-bit grey PNG file; 255: unchanged");
  command.option("--supports", args.supports, "Generate supports: auto, on or off")
      .one_of({"auto", "on", "off"});
  add_size_options(command, options.size);
  command.option("--gamma", args.gamma, "Gamma of the projector, which the masks compensate");
  command.option("--threshold", args.threshold, "Make grey below this value black");
  command.option("--force", options.force, "Replace the files of an earlier slice");
  command.option("--fit", options.fit, "Scale the model to fill the display");
  command.option("--json", options.json, "Print JSON");
  command.run = [&args] { return slice(parse_slice(args)); };
}

}  // namespace contourd::ctl
