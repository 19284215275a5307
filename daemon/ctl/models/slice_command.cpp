#include "daemon/ctl/models/model_commands.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "core/analysis/print_analysis.hpp"
#include "core/contour/filled_area.hpp"
#include "core/engine/contour_engine.hpp"
#include "core/layers/adaptive_layers.hpp"
#include "core/layers/layer_statistics.hpp"
#include "core/layers/print_layers.hpp"
#include "daemon/ctl/models/layer_files.hpp"
#include "daemon/ctl/models/layer_measurements.hpp"
#include "daemon/ctl/models/model_arguments.hpp"
#include "daemon/ctl/models/print_subject.hpp"
#include "daemon/ctl/models/read_model.hpp"
#include "daemon/ctl/models/sl1_file.hpp"
#include "daemon/ctl/models/supported_model.hpp"
#include "daemon/ctl/terminal/exit_codes.hpp"
#include "daemon/prepare/mesh_repair_text.hpp"
#include "daemon/prepare/model_checks.hpp"
#include "daemon/prepare/print_findings.hpp"
#include "daemon/prepare/supports_text.hpp"
#include "daemon/system/readable.hpp"
#include "hw/png_file.hpp"

namespace contourd::ctl {
namespace {

struct SliceOptions {
  // With a printer's configuration or a resin's profile, the layers of a print are sliced. Without, exactly
  // one of these is given: one height (in the file's coordinates), uniform layers, or adaptive layers.
  PrintArgs print;
  std::optional<Millimeters> z;
  std::optional<Nanometers> layer_height;
  std::optional<AdaptiveLayers> adaptive;
  bool json = false;

  std::optional<UpOption> up;  // applied first; z then refers to the turned model

  EngineSettings engine;
  bool fit = false;
  SupportPolicy supports =
      SupportPolicy::Off;  // layers then count from the plate; z still refers to the file
  std::optional<std::filesystem::path> uniformity;  // picture to read into engine.uniformity

  std::optional<std::filesystem::path> mask;      // one PNG, with z
  std::optional<std::filesystem::path> masks;     // a folder of PNGs, with layers
  std::optional<std::filesystem::path> csv;       // with layers
  std::optional<std::filesystem::path> sl1;       // a sliced archive, of a print
  std::optional<std::filesystem::path> contours;  // a folder of CSVs, with layers
  bool force = false;                             // replace the files of an earlier slice in these folders

  [[nodiscard]] bool is_print() const { return print.printer || print.resin; }
};

// Arguments as the user typed them, before they have units.
struct SliceArgs {
  SliceOptions options;
  std::optional<double> z_mm, cusp_um;
  double min_layer_um = 25, max_layer_um = 100;
  double grow_um = 0, elephant_foot_um = 0, elephant_foot_height_um = 0, gamma = 1;
  int threshold = 0;
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

void parse_layers(const SliceArgs& args, SliceOptions& options) {
  const std::optional<double>& height_um = options.print.layer_height_um;
  if (args.z_mm) {
    if (!std::isfinite(*args.z_mm))
      throw UsageError(fmt::format("--z {}: expected a finite number", *args.z_mm));
    options.z = Millimeters{*args.z_mm};
    if (options.masks || options.csv || options.contours)
      throw UsageError("--masks, --csv and --contours need --layer-height-um or --cusp-um");
  }
  if (height_um) options.layer_height = parse_um("--layer-height-um", *height_um, 1);
  if (args.cusp_um) options.adaptive = parse_adaptive(args);
  if (options.is_print()) return;
  if (int{args.z_mm.has_value()} + int{height_um.has_value()} + int{args.cusp_um.has_value()} != 1)
    throw UsageError(
        "slice needs exactly one of --z, --layer-height-um and --cusp-um, or a print: --printer or --resin");
}

SliceOptions parse_slice(const SliceArgs& args) {
  SliceOptions options = args.options;
  const PrintArgs& print = options.print;
  options.supports = support_policy(print.supports.value_or("off"));
  (void)parse_size(print.size);
  // Supports have sizes in millimetres, and a picture that fills the display has no scale.
  if (options.supports != SupportPolicy::Off && options.fit)
    throw UsageError(fmt::format("--supports {} excludes --fit", *print.supports));
  options.up = parse_up(print.up);
  options.engine.display = parse_display(print.display);
  options.engine.anti_aliasing = parse_anti_aliasing(print.display);
  parse_corrections(options.engine, args);
  refuse_to_overwrite_model(print.model, "--mask", options.mask);
  refuse_to_overwrite_model(print.model, "--csv", options.csv);
  refuse_to_overwrite_model(print.model, "--sl1", options.sl1);
  parse_layers(args, options);
  if (options.force && !options.masks && !options.contours)
    throw UsageError("--force needs --masks or --contours");
  if (options.mask && !args.z_mm) throw UsageError("--mask needs --z");
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
void add_supports(const std::optional<Supports>& supports, Json& json) {
  if (supports) json["supports"] = supports_summary_json(counts_of(*supports));
}
void print_supports(const std::optional<Supports>& supports) {
  if (supports) fmt::print("supports     {}\n", supports_line(counts_of(*supports)));
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
    add_supports(supported.supports, json);
    fmt::print("{}\n", json.dump(2));
    return kOk;
  }
  fmt::print("z            {:.6g} mm\nsegments     {}\ncontours     {}\n", z.count(), section.segments.size(),
             contours.closed_loops());
  fmt::print("open chains  {}\nturned       {}\ngaps closed  {}, the widest {:.6g} mm\n",
             contours.cracks.open_chains, contours.cracks.turned_chains, contours.cracks.gaps_closed,
             contours.cracks.widest_gap.count());
  fmt::print("area         {:.6g} mm²\nperimeter    {:.6g} mm\n", area, perimeter);
  print_supports(supported.supports);
  return kOk;
}

// The layers of a model, and the masks that they are to have.
struct LayersToSlice {
  PlateModel model;
  std::vector<Nanometers> middles;  // heights above the plate at which the layers are cut
  const std::optional<Supports>& supports;
  std::function<MaskMaker()> make_masks;
  std::function<std::vector<LayerCracks>()> write_sl1{};  // empty: no archive is written
};

struct MeasuredLayers {
  std::vector<LayerMeasurement> measurements;
  std::vector<LayerCracks> cracks;
};

// Times slicing and joining of each layer (thesis, section 3.5).
MeasuredLayers measure_layers(const SliceOptions& options, const LayersToSlice& layers) {
  const PlateModel& model = layers.model;
  const Millimeters tolerance = to_millimeters(options.engine.display.pixel_pitch);
  LayerStopwatch stopwatch;
  MeasuredLayers measured;
  for (const Nanometers middle : layers.middles) {
    measured.measurements.push_back(stopwatch.measure(*model.model, model.z_at(middle), tolerance));
    const Contours& contours = stopwatch.contours();
    measured.cracks.push_back(contours.cracks);
    if (options.contours)
      write_contours(*options.contours / layer_file(measured.cracks.size(), ".csv"), contours,
                     model.copies.front());
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

void report_measurements(const SliceOptions& options, const LayersToSlice& layers,
                         const MeasuredLayers& measured) {
  const std::size_t facets = layers.model.model->facets().size();
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
    print_supports(layers.supports);
    fmt::print("\n");
    return print_statistics(statistics);
  }
  Json json{{"facets", facets}, {"layers", measurements.size()}};
  json.update(statistics_json(statistics));
  json.update(cracks_json(total_of(measured.cracks)));
  json["cracked_layer_list"] = cracked_layers_json(measured.cracks);
  add_supports(layers.supports, json);
  fmt::print("{}\n", json.dump(2));
}

int slice_layers(const SliceOptions& options, const LayersToSlice& layers) {
  if (layers.middles.empty()) {
    throw ModelError(fmt::format("{}: the model is {:.6g} mm high, too thin for a layer",
                                 options.print.model.string(), layers.model.model->bounds().size_z()));
  }
  const bool is_measured =
      options.csv || options.contours || options.json || (!options.masks && !options.sl1);
  if (layers.model.has_finished_layers() && is_measured)
    throw ModelError(
        fmt::format("{}: the file holds finished layers and no model that could be measured: "
                    "use --masks or --sl1 without --csv, --contours and --json",
                    options.print.model.string()));
  const Earlier earlier = options.force ? Earlier::Replace : Earlier::Refuse;
  if (options.masks) open_layer_folder(*options.masks, ".png", earlier);
  if (options.contours) open_layer_folder(*options.contours, ".csv", earlier);
  // Layers are measured unless only masks are written.
  std::vector<LayerCracks> cracks;
  if (is_measured) {
    MeasuredLayers measured = measure_layers(options, layers);
    report_measurements(options, layers, measured);
    cracks = std::move(measured.cracks);
  }
  if (options.masks) {
    cracks = write_masks(*options.masks, layers.middles, layers.make_masks);
    if (!options.json)
      fmt::print("{} in {}\n", count_of(layers.middles.size(), "mask", "masks"), options.masks->string());
  }
  if (layers.write_sl1) cracks = layers.write_sl1();
  warn_if_cracked(cracks);
  return kOk;
}

// Slices the layers of a print, with its masks.
int slice_print(SliceOptions options) {
  options.print.tone = options.engine.tone;
  options.print.uniformity = std::move(options.engine.uniformity);
  const PrintSubject subject = print_subject(options.print);
  options.engine = subject.settings;
  print_warnings(subject.warnings);
  LayersToSlice layers{subject.engine->models().front(), middles_of(subject.layers), subject.supports, [&] {
                         return MaskMaker{*subject.engine, subject.dimmed_masks(), subject.given_light()};
                       }};
  if (options.sl1)
    layers.write_sl1 = [&] {
      std::vector<LayerCracks> cracks = write_sl1(*options.sl1, options.print.model, subject);
      if (!options.json)
        fmt::print("{} in {}\n", count_of(cracks.size(), "layer", "layers"), options.sl1->string());
      return cracks;
    };
  return slice_layers(options, layers);
}

// Warns if the corrections of the masks erase walls or pins.
void warn_if_erased(const SliceOptions& options, const SupportedModel& supported,
                    const std::vector<Nanometers>& heights) {
  if (!options.mask && !options.masks) return;
  const LightSearch search{options.engine, heights, CarryingSupport{}.least_grey, kLongestMask};
  if (const std::string erased = erased_sentence({supported.model}, search); !erased.empty())
    fmt::print(stderr, "contourctl: warning: {}\n", erased);
}

// Slices the model as it is in its file, or with supports.
int slice_model(const SliceOptions& options) {
  Model read = read_turned_model(options.print.model, options.up, options.print.size);
  print_warnings(read.warnings);
  const auto model = std::make_shared<const HeightIndex>(std::move(read.facets));
  print_warnings(mesh_warnings(model->turned_outwards(), model->repairs()));
  const SupportedModel supported = stand(model, options);
  print_warnings(supported.warnings());
  if (options.z) {
    if (const auto height = to_nanometers(*options.z - supported.model.z_at(Nanometers{})))
      warn_if_erased(options, supported, {*height});
    return slice_at_height(options, supported);
  }
  const PrintLayers layers =
      print_layers(supported.model, options.layer_height.value_or(Nanometers{}), options.adaptive);
  warn_if_erased(options, supported, middles_of(layers.all()));
  if (options.masks) warn_if_larger_than_display(options, model->bounds());
  return slice_layers(options, {supported.model, middles_of(layers.all()), supported.supports,
                                [&] { return MaskMaker{supported.engine(options.engine)}; }});
}

int slice(SliceOptions options) {
  if (options.print.undersides && !options.is_print())
    throw UsageError("--undersides needs --printer, or --resin with the resin's profile");
  if (options.uniformity)
    options.engine.uniformity = read_uniformity_mask(*options.uniformity, options.engine.display);
  return options.is_print() ? slice_print(std::move(options)) : slice_model(options);
}

}  // namespace

void add_slice(Command& program) {
  Command& command = program.add("slice", "Slice a model at one height or into layers");
  auto& args = command.arguments<SliceArgs>();
  SliceOptions& options = args.options;
  const auto [printer, resin] =
      add_print_options(command, options.print, "Layer height, um (with --resin, default: the resin's)");
  const auto add = [&](const char* name, auto& variable, const char* help) -> Option& {
    return command.option(name, variable, help);
  };
  Option& cusp =
      add("--cusp-um", args.cusp_um, "Adaptive layers: maximum distance of an edge from the surface, um");
  add("--min-layer-um", args.min_layer_um, "Thinnest adaptive layer, um").needs(cusp);
  add("--max-layer-um", args.max_layer_um, "Thickest adaptive layer, um").needs(cusp);
  Option& gamma = add("--gamma", args.gamma, "Gamma of the projector, which the masks compensate");
  Option& threshold = add("--threshold", args.threshold, "Make grey below this value black");
  Option& uniformity = add("--uniformity-mask", options.uniformity,
                           "Darken the masks by this 8-bit grey PNG file; 255: unchanged");
  for (Option* of_projector : {&gamma, &threshold, &uniformity})
    of_projector->excludes(printer);
  Option& z = add("--z", args.z_mm, "Height of the cut, mm, in the file's coordinates");
  Option& grow = add("--grow-um", args.grow_um, "Move the contours outwards, um; negative: inwards");
  Option& foot =
      add("--elephant-foot-um", args.elephant_foot_um, "Move the contours inwards at the bottom, um");
  Option& foot_height = add("--elephant-foot-height-um", args.elephant_foot_height_um,
                            "Height over which the elephant foot correction fades, um");
  Option& fit = add("--fit", options.fit, "Scale the model to fill the display");
  for (Option* of_model : {&cusp, &z, &grow, &foot, &foot_height, &fit})
    of_model->excludes(printer).excludes(resin);
  add("--mask", options.mask, "Write the mask at --z to this PNG file");
  add("--masks", options.masks, "Write one PNG file per layer to this folder: 0001.png ...");
  add("--sl1", options.sl1, "Write the layers as a sliced archive (.sl1) for other tools").needs(printer);
  add("--csv", options.csv, "Write layer measurements to this file, totals to FILE-summary.csv");
  add("--contours", options.contours, "Write one CSV file of contour points per layer to this folder");
  add("--force", options.force, "Replace the files of an earlier slice");
  add("--json", options.json, "Print JSON");
  command.run = [&args] { return slice(parse_slice(args)); };
}

}  // namespace contourd::ctl
