#include "daemon/print_job.hpp"

#include <fmt/format.h>

#include <cmath>
#include <new>
#include <system_error>
#include <utility>

#include "core/placement.hpp"

namespace contourd {
namespace {

using SteadyClock = std::chrono::steady_clock;

// Between copies on one plate, so that cured resin does not join them.
constexpr double kCopyGapMm = 2.0;

StlModel read_model(const JobFiles& files) {
  try {
    StlModel model = read_stl_file(files.model);
    if (model.facets.empty()) throw JobRefused("the STL file holds no facets");
    return model;
  } catch (const StlError& error) {
    throw JobRefused(fmt::format("not a usable STL file: {}", error.what()));
  } catch (const std::bad_alloc&) {
    throw JobRefused("the model does not fit into this machine's memory");
  }
}

DisplayGeometry display_of(const PrinterConfig& printer) {
  return {printer.display_width, printer.display_height, printer.pixel_pitch, printer.mirror_x,
          printer.mirror_y};
}

EngineSettings engine_settings(const PrinterConfig& printer, const ResinProfile& resin) {
  return {display_of(printer), printer.anti_aliasing ? AntiAliasing::On : AntiAliasing::Off,
          resin.compensation, printer.tone, printer.lamp};
}

struct BuildVolume {
  double x_mm, y_mm, z_mm;
};

BuildVolume build_volume(const PrinterConfig& printer, const ResinProfile& resin) {
  const double pitch_mm = to_millimeters(printer.pixel_pitch).count();
  // Every layer is peeled off by a lift, the last one too.
  return {printer.display_width.count() * pitch_mm, printer.display_height.count() * pitch_mm,
          to_millimeters(printer.travel - resin.lift).count()};
}

// As large as the thesis's equations 3.6 to 3.19 draw it, but in all three directions alike, and no higher
// than the machine: a part that is to be printed must keep its shape.
double scale_to_fit(const Bounds& bounds, const PrinterConfig& printer, const BuildVolume& volume) {
  const double pixels_per_mm = PixelMap::fit(display_of(printer), bounds).pixels_per_mm_x();
  const double fit_display = pixels_per_mm * to_millimeters(printer.pixel_pitch).count();
  return std::min(fit_display, volume.z_mm / bounds.size_z());
}

Bounds place(std::vector<Facet>& facets, const JobTicket& ticket, const PrinterConfig& printer,
             const BuildVolume& volume, JobSummary& summary) {
  Orientation turn{ticket.rotation.x, ticket.rotation.y, ticket.rotation.z, 1.0};
  if (ticket.fit) {
    orient(facets, turn);
    turn = Orientation{};
    turn.scale = scale_to_fit(bounds_of(facets), printer, volume);
  } else {
    turn.scale = ticket.scale.value_or(1.0);
  }
  orient(facets, turn);
  summary.scale = turn.scale;
  const Bounds bounds = bounds_of(facets);
  if (!std::isfinite(bounds.size_x() + bounds.size_y() + bounds.size_z())) {
    throw JobRefused("the model is too large: its coordinates leave the range of numbers");
  }
  if (!(bounds.size_z() > 0)) throw JobRefused("the model is flat: it has no height to print");
  summary.size_x_mm = bounds.size_x();
  summary.size_y_mm = bounds.size_y();
  summary.size_z_mm = bounds.size_z();
  return bounds;
}

// Centres of the copies on the plate, relative to its own centre: rows of columns, as near to a square as
// the plate allows.
std::vector<Point> arrange_copies(const Bounds& bounds, const JobTicket& ticket, const BuildVolume& volume) {
  const double pitch_x = bounds.size_x() + kCopyGapMm, pitch_y = bounds.size_y() + kCopyGapMm;
  const double columns_that_fit = std::fmax(1, std::floor((volume.x_mm + kCopyGapMm) / pitch_x));
  const double rows_that_fit = std::fmax(1, std::floor((volume.y_mm + kCopyGapMm) / pitch_y));
  if (ticket.copies > columns_that_fit * rows_that_fit) {
    throw JobRefused(
        fmt::format("{} copies of {:.2f} x {:.2f} mm do not fit on the plate ({:.2f} x {:.2f} mm); there is "
                    "room for {:.0f}",
                    ticket.copies, bounds.size_x(), bounds.size_y(), volume.x_mm, volume.y_mm,
                    columns_that_fit * rows_that_fit));
  }
  const double square = std::ceil(std::sqrt(ticket.copies * pitch_y / pitch_x));
  const double fewest_columns = std::ceil(ticket.copies / rows_that_fit);
  const double columns =
      std::fmin(std::fmin(columns_that_fit, ticket.copies), std::fmax(fewest_columns, square));
  const double rows = std::ceil(ticket.copies / columns);
  std::vector<Point> centers;
  for (int copy = 0; copy < ticket.copies; ++copy) {
    const double column = std::fmod(copy, columns), row = std::floor(copy / columns);
    centers.push_back({ticket.position.x.count() + (column - (columns - 1) / 2) * pitch_x,
                       ticket.position.y.count() + ((rows - 1) / 2 - row) * pitch_y});
  }
  return centers;
}

void check_inside(const Bounds& bounds, const std::vector<Point>& centers, const BuildVolume& volume) {
  // A thousandth of a millimetre: the rounding of float coordinates, far below a pixel.
  constexpr double kRoundingMm = 1e-3;
  if (bounds.size_z() > volume.z_mm + kRoundingMm) {
    throw JobRefused(
        fmt::format("the model is {:.2f} mm high, the machine can print {:.2f} mm (its travel less the lift)",
                    bounds.size_z(), volume.z_mm));
  }
  for (const Point& center : centers) {
    const double reach_x = std::fabs(center.x) + bounds.size_x() / 2,
                 reach_y = std::fabs(center.y) + bounds.size_y() / 2;
    if (reach_x <= volume.x_mm / 2 + kRoundingMm && reach_y <= volume.y_mm / 2 + kRoundingMm) continue;
    throw JobRefused(
        fmt::format("the model ({:.2f} x {:.2f} mm, its centre {:.2f}, {:.2f} mm from the plate's) reaches "
                    "beyond the display ({:.2f} x {:.2f} mm)",
                    bounds.size_x(), bounds.size_y(), center.x, center.y, volume.x_mm, volume.y_mm));
  }
}

// A part that fills the display is not refused for some micrometres that it grows by.
void warn_if_grown_beyond(const Bounds& bounds, const std::vector<Point>& centers, const BuildVolume& volume,
                          JobSummary& summary) {
  const double growth_mm = to_millimeters(summary.resin.compensation.growth).count();
  for (const Point& center : centers) {
    const double beyond = std::fmax(std::fabs(center.x) + bounds.size_x() / 2 - volume.x_mm / 2,
                                    std::fabs(center.y) + bounds.size_y() / 2 - volume.y_mm / 2) +
                          growth_mm;
    // A micrometre: the rounding of float coordinates.
    if (growth_mm <= 0 || beyond <= 1e-3) continue;
    summary.warnings.push_back(fmt::format(
        "the resin's growth_um moves contours {:.0f} um beyond the display, where they are cut off",
        beyond * 1000));
    return;
  }
}

std::vector<PixelMap> maps_of(const std::vector<Point>& centers, const Bounds& bounds,
                              const PrinterConfig& printer) {
  std::vector<PixelMap> maps;
  const Point middle = bounds.center();
  for (const Point& center : centers) {
    // The point of the model that comes to lie on the display's centre.
    maps.push_back(PixelMap::true_scale(display_of(printer), {middle.x - center.x, middle.y - center.y}));
  }
  return maps;
}

LayerStack choose_layers(const JobTicket& ticket, const ResinProfile& resin, const PrinterConfig& printer,
                         const Bounds& bounds) {
  const Nanometers thickness = ticket.layer_height.value_or(resin.layer_height);
  const auto problems = layer_height_problems(resin, thickness, printer.irradiance_mw_cm2);
  if (!problems.empty()) {
    std::string reasons;
    for (const std::string& problem : problems)
      reasons += (reasons.empty() ? "" : "; ") + problem;
    throw JobRefused(fmt::format("the layer height cannot be printed: {}", reasons));
  }
  const std::optional<LayerStack> layers = layers_for(Millimeters{bounds.size_z()}, thickness);
  if (!layers) throw JobRefused("the model has more layers than can be counted");
  if (layers->count == 0) {
    throw JobRefused(fmt::format("the model is {:.6g} mm high, too thin for a layer", bounds.size_z()));
  }
  return *layers;
}

void warn_about_mesh(JobSummary& summary) {
  const MeshReport& mesh = summary.mesh;
  if (!mesh.watertight) {
    summary.warnings.push_back(
        fmt::format("the model is not watertight ({} open edges, {} turned against each other, {} of more "
                    "than two facets): gaps are "
                    "closed where they show",
                    mesh.open_edges, mesh.flipped_edges, mesh.non_manifold_edges));
  }
  if (mesh.volume_mm3 < 0)
    summary.warnings.emplace_back("the model is inside out; it is printed all the same");
}

PreparedJob prepare(const JobFiles& files, const PrinterConfig& printer) {
  const auto start = SteadyClock::now();
  const JobTicket ticket = files.ticket ? load_job_ticket(*files.ticket) : JobTicket{};
  PreparedJob job;
  JobSummary& summary = job.summary;
  summary.resin = ticket.resin ? find_resin(printer, *ticket.resin) : printer.resin;
  StlModel model = read_model(files);
  const auto read = SteadyClock::now();
  summary.format = model.format;
  summary.warnings = std::move(model.warnings);
  summary.rotation_deg = ticket.rotation;
  summary.position = ticket.position;
  summary.copies = ticket.copies;
  summary.tone = printer.tone;
  summary.lamp_mask = printer.lamp.has_value();
  const BuildVolume volume = build_volume(printer, summary.resin);
  const Bounds bounds = place(model.facets, ticket, printer, volume, summary);
  const std::vector<Point> centers = arrange_copies(bounds, ticket, volume);
  check_inside(bounds, centers, volume);
  warn_if_grown_beyond(bounds, centers, volume, summary);
  summary.layers = choose_layers(ticket, summary.resin, printer, bounds);
  HeightIndex index(std::move(model.facets));
  const auto indexed = SteadyClock::now();
  PrintPlan& plan = job.plan;
  plan.job = files.name;
  plan.layers = summary.layers;
  plan.engine = std::make_unique<ContourEngine>(std::move(index), engine_settings(printer, summary.resin),
                                                maps_of(centers, bounds, printer));
  // Computed for its time, and to have the engine's memory grown before the print needs it.
  (void)plan.engine->mask_at(summary.layers.middle_of(0));
  job.first_mask_at = SteadyClock::now();
  summary.reading = read - start;
  summary.indexing = indexed - read;
  summary.first_mask = job.first_mask_at - indexed;
  for (std::int32_t layer = 0; layer < plan.layers.count; ++layer) {
    plan.exposures.push_back(
        exposure_time(summary.resin, plan.layers.thickness, layer, printer.irradiance_mw_cm2));
  }
  const double pitch_mm = to_millimeters(printer.pixel_pitch).count();
  plan.pixel_area_mm2 = pitch_mm * pitch_mm;
  plan.lift = summary.resin.lift;
  plan.lift_speed = summary.resin.lift_speed;
  plan.retract_speed = summary.resin.retract_speed;
  plan.travel_speed = printer.travel_speed;
  plan.settle = summary.resin.settle;
  plan.rest = summary.resin.rest;
  summary.mesh = inspect_mesh(plan.engine->model().facets());
  warn_about_mesh(summary);
  return job;
}

}  // namespace

std::string describe_correction(const JobSummary& summary) {
  const Compensation& c = summary.resin.compensation;
  std::string text;
  const auto add = [&text](const std::string& clause) { text += (text.empty() ? "" : ", ") + clause; };
  if (c.growth != Micrometers{}) {
    add(fmt::format("contours moved {} by {:g} um", c.growth > Micrometers{} ? "outwards" : "inwards",
                    std::fabs(c.growth.count())));
  }
  if (c.elephant_foot != Micrometers{}) {
    add(fmt::format("elephant foot of {:g} um over {:g} um of height taken off", c.elephant_foot.count(),
                    to_millimeters(c.elephant_foot_height).count() * 1000));
  }
  if (summary.lamp_mask) add("lamp evened out");
  if (summary.tone.gamma != 1.0) add(fmt::format("gamma {:g}", summary.tone.gamma));
  if (summary.tone.threshold != 0) add(fmt::format("grey below {} left dark", summary.tone.threshold));
  return text;
}

PreparedJob prepare_job(const JobFiles& files, const PrinterConfig& printer) {
  try {
    return prepare(files, printer);
  } catch (const ConfigError& error) {
    throw JobRefused(fmt::format("the job ticket is wrong:\n{}", error.what()));
  } catch (const std::system_error& error) {
    throw JobRefused(error.what());
  } catch (const std::range_error& error) {
    throw JobRefused(error.what());
  } catch (const std::bad_alloc&) {
    throw JobRefused("the model does not fit into this machine's memory");
  }
}

}  // namespace contourd
