#include "daemon/report/print_report_json.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "daemon/prepare/job_summary.hpp"
#include "daemon/prepare/mesh_repair_text.hpp"
#include "daemon/prepare/print_findings.hpp"
#include "daemon/prepare/supports_text.hpp"
#include "daemon/report/cured_part_text.hpp"
#include "daemon/report/range_times.hpp"
#include "daemon/report/rise_forecast_text.hpp"
#include "daemon/report/time_causes.hpp"
#include "daemon/system/readable.hpp"

namespace contourd {
namespace {

using Json = nlohmann::ordered_json;

Json scale_json(const Scale& scale) {
  if (scale.uniform()) return scale.x;
  return {scale.x, scale.y, scale.z};
}

Json hollow_json(const HollowSummary& hollow) {
  Json json = {{"wall_mm", hollow.settings.wall.count()},
               {"cavities", hollow.cavities},
               {"volume_ml", hollow.volume_mm3 / 1000},
               {"cell_mm", hollow.cell.count()},
               {"holes_added", hollow.holes.size()}};
  if (hollow.settings.infill)
    json["infill"] = {{"cell_mm", hollow.settings.infill->cell.count()},
                      {"strut_mm", hollow.settings.infill->strut.count()}};
  return json;
}

Json model_json(const ModelSummary& model) {
  const MeshReport& mesh = model.mesh;
  Json json;
  if (!model.file.empty()) json["file"] = model.file;
  json["format"] = model.format;
  json["facets"] = mesh.facets;
  json["size_mm"] = {model.size_x_mm, model.size_y_mm, model.size_z_mm};
  json["scale"] = scale_json(model.scale);
  if (model.up) {
    json["up"] = {model.up->x, model.up->y, model.up->z};
  } else {
    json["rotation_deg"] = {model.rotation_deg.x, model.rotation_deg.y, model.rotation_deg.z};
  }
  json["drain_holes"] = model.drain_holes;
  if (model.hollow) json["hollow"] = hollow_json(*model.hollow);
  if (model.orientation) json["orientation"] = orientation_json(*model.orientation);
  json["copies"] = model.centers.size();
  Json centers = Json::array();
  for (const Point& center : model.centers)
    centers.push_back({center.x, center.y});
  json["positions_mm"] = std::move(centers);
  json["watertight"] = mesh.watertight;
  json["open_edges"] = mesh.open_edges;
  json["repairs"] = repairs_json(model.repairs);
  return json;
}

// Adds the list "models" for a plate, else the object "model".
void add_models(const JobSummary& summary, Json& json) {
  if (summary.plate) {
    json["models"] = Json::array();
    for (const ModelSummary& model : summary.models)
      json["models"].push_back(model_json(model));
    json["warnings"] = summary.warnings;
    return;
  }
  Json model = model_json(summary.models.front());
  const std::vector<Point>& centers = summary.models.front().centers;
  Point middle{};
  for (const Point& center : centers) {
    middle.x += center.x / static_cast<double>(centers.size());
    middle.y += center.y / static_cast<double>(centers.size());
  }
  model["position_mm"] = {middle.x, middle.y};
  model["warnings"] = summary.warnings;
  json["model"] = std::move(model);
}

// Returns the settings that determine the exposure of every layer.
Json exposure_json(const JobSummary& summary) {
  const Scale& made_larger = summary.resin.shrinkage_factors;
  const auto percent = [](double factor) { return 100 * (1 - 1 / factor); };
  Json json{{"irradiance_mw_cm2", summary.irradiance_mw_cm2},
            {"shrinkage_percent", {percent(made_larger.x), percent(made_larger.y), percent(made_larger.z)}},
            {"support_grey", summary.resin.support.least_grey},
            {"support_area_mm2", summary.resin.support.contact_area_mm2}};
  if (const auto* fixed = std::get_if<FixedExposure>(&summary.resin.exposure)) {
    json["exposure_ms"] = in_ms(fixed->exposure);
    json["bottom_exposure_ms"] = in_ms(fixed->bottom_exposure);
    for (const auto& [from, exposure] : fixed->steps)
      json["exposure_steps"].push_back({{"from_mm", in_mm(from)}, {"exposure_ms", in_ms(exposure)}});
    return json;
  }
  const auto& by_curve = std::get<CurveExposure>(summary.resin.exposure);
  const WorkingCurve& curve = summary.resin.cure.value().curve;
  json["working_curve"] = {{"penetration_depth_um", curve.penetration_depth.count()},
                           {"critical_energy_mj_cm2", curve.critical_dose.count()},
                           {"overcure_um", by_curve.overcure.count()},
                           {"bottom_overcure_um", by_curve.bottom_overcure.count()}};
  if (const auto& followed = summary.temperature)
    json["temperature"] = {
        {"resin_c", followed->resin_c}, {"curve_c", followed->curve_c}, {"light", followed->light}};
  return json;
}

void add_layer_figures(const LayerSummary& layers, Json& json) {
  if (layers.adaptive) {
    json["adaptive_layers"] = {{"cusp_um", in_mm(layers.adaptive->cusp) * 1000},
                               {"min_um", in_mm(layers.adaptive->thinnest) * 1000},
                               {"max_um", in_mm(layers.adaptive->thickest) * 1000}};
  } else {
    json["layer_height_um"] = in_mm(layers.thinnest) * 1000;
  }
  json["layers"] = layers.count;
}

// Adds the times of the states, the interruptions and the pauses.
void add_stops(const PrintReport& report, Json& json) {
  const PrintStops& stops = report.stops;
  Json states = Json::object(), interruptions = Json::array(), pauses = Json::array();
  for (const auto& [state, time] : report.states.totals())
    if (time > Duration{0}) states[std::string(state.name)] = in_seconds(time);
  for (const PrintInterruption& each : stops.interruptions)
    interruptions.push_back(fmt::format("layer {}: {}", each.layer + 1, each.what));
  if (stops.more_interruptions > 0)
    interruptions.push_back(fmt::format("and {} more", stops.more_interruptions));
  for (const PrintPause& each : stops.pauses)
    pauses.push_back(
        {{"layer", each.layer + 1}, {"at_s", in_seconds(each.at)}, {"lasted_s", in_seconds(each.lasted)}});
  json["states_s"] = std::move(states);
  json["time"] = times_json(report);
  json["interruptions"] = std::move(interruptions);
  json["pauses"] = std::move(pauses);
  json["pause_count"] = stops.pauses.size() + stops.more_pauses;
}

Json changes_json(const PrintReport& report) {
  Json list = Json::array();
  for (const SettingChange& each : report.changes)
    list.push_back({{"from_layer", each.layer + 1},
                    {"from_mm", each.height ? Json(in_mm(*each.height)) : Json()},
                    {"setting", each.setting},
                    {"value", each.value},
                    {"before", each.before},
                    {"unit", unit_of(each.setting)}});
  return list;
}

Json exclusions_json(const PrintReport& report) {
  Json list = Json::array();
  for (const Exclusion& each : report.exclusions)
    list.push_back({{"copy", each.copy}, {"number", each.number + 1}, {"from_layer", each.layer + 1}});
  return list;
}

Json cured_json(const PrintReport& report) {
  if (!report.cured) return {};
  if (!report.cured->part) return {{"not_computed", report.cured->why_not}};
  Json json = cured_part_json(*report.cured->part);
  if (report.cured->rise) json["rise"] = rise_light_json(*report.cured->rise);
  json["warnings"] = warnings_of(*report.cured, report.summary.resin.peel_memory_measured);
  return json;
}

// Returns the masks of a rise or of a slice of it.
Json frames_json(const FrameFigures& frames) {
  return {{"shown", frames.shown},
          {"missed", frames.missed},
          {"slowed", frames.slowed},
          {"farthest_um", in_mm(frames.farthest) * 1000},
          {"longest_cut_ms", in_ms(frames.longest_cut)}};
}

// Returns the masks of all rises, and the file that lists them; null if there was no rise.
Json rise_json(const PrintReport& report) {
  if (std::ranges::find(report.layers, true, &LayerRecord::rises) == report.layers.end()) return {};
  Json json = frames_json(frame_figures(report.layers));
  if (report.frames)
    json.update(Json{
        {"file", report.frames->name}, {"recorded", report.frames->recorded}, {"lost", report.frames->lost}});
  return json;
}

// Returns the plan of the rises when the print began, and as it was changed; null if the print is layered.
Json rises_json(const PrintReport& report) {
  const auto plan_json = [&report](const ContinuousForecast& plan) {
    return continuous_json(plan, range_times(report, plan.ranges));
  };
  if (!report.summary.continuous) return {};
  Json json = plan_json(*report.summary.continuous);
  json["changed"] = Json::array();
  for (const ChangedForecast& each : report.changed_rises) {
    Json changed{{"from_mm", in_mm(each.from)},
                 {"set",
                  {{"speed_mm_h", each.settings.speed_mm_h},
                   {"light_percent", each.settings.light_percent},
                   {"margin", each.settings.margin}}}};
    changed.update(plan_json(each.plan));
    json["changed"].push_back(std::move(changed));
  }
  return json;
}

// Returns the peel of a layer; null if it is not known.
Json peel_json(const std::optional<PeelRecord>& peel) {
  if (!peel) return {};
  return {{"felt", peel->felt},
          {"distance_mm", peel->distance ? Json(in_mm(*peel->distance)) : Json()},
          {"saved_s", in_seconds(peel->saved)},
          {"missed", peel->missed}};
}

// Returns the peels of the print; null if none is known.
Json peels_json(const PrintReport& report) {
  const PeelFigures peels = peel_figures(report.layers);
  if (peels.judged == 0) return {};
  return {{"layers", peels.judged},
          {"felt", peels.felt},
          {"missed", peels.missed},
          {"saved_s", in_seconds(peels.saved)}};
}

Json layer_json(const LayerRecord& layer) {
  Json json{{"layer", layer.layer + 1},
            {"thickness_um", in_mm(layer.thickness) * 1000},
            {"plate_height_mm", in_mm(layer.plate_height)},
            {"mask_height_mm", in_mm(layer.mask_height)},
            {"settle_ms", in_ms(layer.settling)},
            {"exposure_asked_ms", in_ms(layer.exposure_asked)},
            {"exposure_least_ms", in_ms(layer.exposure_least)},
            {"exposure_most_ms", in_ms(layer.exposure_most)},
            {"exposure_parts", layer.exposure_parts},
            {"pictures", layer.pictures},
            {"light_error_percent", 100 * layer.light_error},
            {"late_picture_ms", in_ms(layer.late_picture)},
            {"frames", layer.rises ? frames_json(layer.frames) : Json()},
            {"complete", layer.complete},
            {"dark_confirmed", layer.dark_confirmed},
            {"shown_at_s", in_ms(layer.shown_at.time_since_epoch()) / 1000},  // by the machine's clock
            {"mask_ms", in_ms(layer.mask_time)},
            {"area_mm2", layer.area_mm2},
            {"peel", peel_json(layer.peel)},
            {"intersecting_facets", layer.intersecting_facets},
            {"loops", layer.loops}};
  json.update(cracks_json(layer.cracks));
  return json;
}

}  // namespace

std::string report_as_json(const PrintReport& report) {
  const JobSummary& summary = report.summary;
  Json json;
  json["job"] = report.job;
  json["printer"] = report.printer;
  json["outcome"] = name_of(report.outcome);
  if (!report.reason.empty()) json["reason"] = report.reason;
  json["started"] = iso_time(report.started);
  json["ended"] = iso_time(report.ended);
  json["print_time_s"] = in_ms(report.print_time) / 1000;
  add_models(summary, json);
  json["dry"] = summary.dry;
  json["resin"] = summary.resin.name;
  json["settings"] = exposure_json(summary);
  for (const auto& [key, value] : motion_figures(summary.resin.motion))
    json["settings"][key] = value;
  json["settings"].update(
      Json{{"exposure_tolerance_ms", in_ms(summary.resin.tolerance.bounds)},
           {"bottom_layers", summary.resin.bottom_layers},
           {"fade_layers", summary.resin.fade_layers},
           {"undersides", summary.resin.undersides == Undersides::Dose ? "dose" : "plain"},
           {"mode", summary.resin.mode == PrintWay::Continuous ? "continuous" : "layered"},
           {"growth_um", summary.resin.compensation.growth.count()},
           {"elephant_foot_um", summary.resin.compensation.elephant_foot.count()},
           {"elephant_foot_height_um", in_mm(summary.resin.compensation.elephant_foot_height) * 1000},
           {"uniformity_mask", summary.uniformity_mask},
           {"gamma", summary.tone.gamma},
           {"pixel_light", pixel_light_json(summary.pixel_light)},
           {"grey_bits", summary.grey_bits},
           {"threshold", summary.tone.threshold}});
  if (summary.supports) json["settings"]["supports"] = support_settings_json(summary.resin.supports);
  json["overrides"] = overrides_json(summary.overridden);
  json["changes"] = changes_json(report);
  json["excluded"] = exclusions_json(report);
  json["supports"] = summary.supports ? supports_json(*summary.supports) : Json();
  add_layer_figures(summary.layers, json);
  json["layers_exposed"] = layers_exposed(report.layers);
  add_stops(report, json);
  json["continuous"] = rises_json(report);
  json["frames"] = rise_json(report);
  json["peel"] = peels_json(report);
  json["unfound_undersides"] = layers_with_unfound_undersides(report.layers);
  json["late_steps"] = report.late_steps;
  json["loop_busy_ms_worst_lit"] = in_ms(report.busiest_lit.busy);
  json["reading_ms"] = in_ms(summary.reading);
  json["indexing_ms"] = in_ms(summary.indexing);
  json["supporting_ms"] = in_ms(summary.supporting);
  json["first_mask_ms"] = in_ms(summary.first_mask);
  json["arrival_to_first_mask_ms"] = in_ms(report.first_mask_after);
  json["exposed_volume_mm3"] = exposed_volume_mm3(report.layers);
  if (report.masks) json["masks_folder"] = report.masks->string();
  json["analysis"] = report.findings ? findings_json(*report.findings) : Json();
  json["cured_part"] = cured_json(report);
  Json layers = Json::array();
  for (const LayerRecord& layer : report.layers)
    layers.push_back(layer_json(layer));
  json["layer_records"] = std::move(layers);
  // File names need not be UTF-8.
  return json.dump(1, ' ', true, Json::error_handler_t::replace) + "\n";
}

}  // namespace contourd
