#include "daemon/web/hosts/odyssey_replies.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string_view>

#include "daemon/web/hosts/host_replies.hpp"

namespace contourd::web {
namespace {

using Json = ControlLink::Json;

constexpr const char* kLocal = "Local";

// Returns the element of a list of contourd's `methods` with this name; null if there is none.
Json named_in(const Json& object, const char* list, std::string_view name) {
  const auto found = object.find(list);
  if (found == object.end() || !found->is_array()) return nullptr;
  for (const Json& each : *found)
    if (each.is_object() && json_text(each, "name") == name) return each;
  return nullptr;
}

double travel_mm(const Json& methods) {
  const Json move = named_in(methods, "methods", "move");
  const Json to = move.is_object() ? named_in(move, "parameters", "to_mm") : Json();
  const auto most = to.find("most");
  return to.is_object() && most != to.end() && most->is_number() ? most->get<double>() : 0.0;
}

}  // namespace

Json odyssey_status(const HostStatus& status) {
  const double z_mm = std::max(status.height_mm.value_or(0.0), 0.0);
  Json reply{
      {"status", status.job ? "Printing" : "Idle"},
      {"paused", status.phase == HostPhase::Paused},
      {"layer", nullptr},
      {"physical_state", {{"z", z_mm}, {"z_microns", std::llround(z_mm * 1000)}, {"curing", status.is_lit}}},
      {"print_data", nullptr}};
  if (status.layer || status.job) reply["layer"] = status.layer.value_or(0);
  if (status.job) reply["print_data"] = odyssey_metadata(*status.job);
  return reply;
}

std::string odyssey_event(const HostStatus& status) {
  return fmt::format("event: status\ndata: {}\n\n", ascii_of(odyssey_status(status)));
}

Json odyssey_file_data(const HostJob& job) {
  // contourd does not tell the time of a file; clients need a number.
  return {{"path", job.file},
          {"name", job.file},
          {"last_modified", 0},
          {"file_size", job.bytes},
          {"location_category", kLocal},
          {"parent_path", ""}};
}

Json odyssey_metadata(const HostJob& job) {
  return {{"file_data", odyssey_file_data(job)}, {"location_category", kLocal},
          {"used_material", job.resin_ml},       {"print_time", job.print_time_s},
          {"layer_height", job.layer_um / 1000}, {"layer_height_microns", std::llround(job.layer_um)},
          {"layer_count", job.layers},           {"material_name", job.resin}};
}

Json odyssey_files(const std::vector<HostJob>& jobs, const OdysseyPage& page) {
  Json files = Json::array();
  const std::size_t first = page.index > jobs.size() / page.size ? jobs.size() : page.index * page.size;
  const std::size_t last = first + std::min(page.size, jobs.size() - first);
  for (std::size_t i = first; i < last; ++i)
    files.push_back(odyssey_metadata(jobs[i]));
  Json reply{{"files", files}, {"dirs", Json::array()}, {"page_index", page.index}, {"page_size", page.size}};
  reply["next_index"] = last < jobs.size() ? Json(page.index + 1) : Json();
  return reply;
}

Json odyssey_config(const std::string& printer, const Json& methods) {
  return {{"general", {{"hostname", printer}}}, {"printer", {{"max_z", travel_mm(methods)}}}};
}

}  // namespace contourd::web
