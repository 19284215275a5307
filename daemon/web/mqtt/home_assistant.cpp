#include "daemon/web/mqtt/home_assistant.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "daemon/system/readable.hpp"

namespace contourd::web {
namespace {

using Json = nlohmann::ordered_json;

struct Button {
  std::string_view method;  // a method of contourd
  const char* name;
  const char* icon;
};
constexpr std::array<Button, 4> kButtons{{{"pause", "Pause", "mdi:pause"},
                                          {"resume", "Resume", "mdi:play"},
                                          {"cancel", "Cancel", "mdi:stop"},
                                          {"plate_cleared", "Plate cleared", "mdi:check"}}};

// Groups of contourd's states, which change several times a second while a layer is made.
struct Group {
  std::string_view name;
  std::array<std::string_view, 4> states;
};
constexpr const char* kPrinting = "printing";
constexpr std::array<Group, 4> kGroups{{{"idle", {"idle"}},
                                        {"preparing", {"preparing", "warming up", "homing"}},
                                        {"paused", {"raising", "paused", "held"}},
                                        {"finishing", {"halting", "parking", "ending", "finishing"}}}};

std::string group_of(const std::string& state) {
  for (const Group& group : kGroups)
    if (!state.empty() && std::ranges::find(group.states, state) != group.states.end())
      return std::string(group.name);
  return kPrinting;
}

Json states() {
  Json all = Json::array({kPrinting});
  for (const Group& group : kGroups)
    all.push_back(group.name);
  return all;
}

// Returns a component that shows a key of the state.
Json shown(const char* platform, const char* name, const char* key, const char* icon) {
  return {{"p", platform},
          {"name", name},
          {"value_template", fmt::format("{{{{ value_json.{} }}}}", key)},
          {"icon", icon}};
}

Json with(Json component, const Json& more) {
  component.update(more);
  return component;
}

Json components(const HomeAssistantTopics& topics) {
  Json all{{"state",
            with(shown("sensor", "State", "state", "mdi:printer-3d"),
                 {{"device_class", "enum"}, {"options", states()}, {"json_attributes_topic", topics.state}})},
           {"progress", with(shown("sensor", "Progress", "progress", "mdi:progress-clock"),
                             {{"unit_of_measurement", "%"}, {"state_class", "measurement"}})},
           {"layer", shown("sensor", "Layer", "layer", "mdi:layers")},
           {"layers", shown("sensor", "Layers", "layers", "mdi:layers-triple")},
           {"time_left", with(shown("sensor", "Time left", "time_left_s", "mdi:timer-sand"),
                              {{"device_class", "duration"}, {"unit_of_measurement", "s"}})},
           {"resin", with(shown("sensor", "Resin", "resin_ml", "mdi:cup-water"),
                          {{"device_class", "volume"}, {"unit_of_measurement", "mL"}})},
           {"outcome", with(shown("sensor", "Last print", "outcome", "mdi:flag-checkered"),
                            {{"device_class", "enum"}, {"options", {"done", "failed", "cancelled"}}})},
           {"problem", with(shown("binary_sensor", "Problem", "problem", "mdi:alert-circle"),
                            {{"device_class", "problem"}})},
           {"plate", shown("binary_sensor", "Plate occupied", "plate", "mdi:tray-full")},
           {"mask",
            {{"p", "image"},
             {"name", "Mask"},
             {"image_topic", topics.picture},
             {"content_type", "image/png"},
             {"icon", "mdi:image"}}}};
  for (const Button& button : kButtons)
    all[std::string(button.method)] = {{"p", "button"},
                                       {"name", button.name},
                                       {"command_topic", topics.commands + std::string(button.method)},
                                       {"payload_press", kPress},
                                       {"icon", button.icon}};
  return all;
}

Json text_or_null(const std::string& text) {
  return text.empty() ? Json() : Json(text);
}

std::string text_in(const Json& object, const char* key) {
  const auto found = object.find(key);
  return found != object.end() && found->is_string() ? printable(found->get<std::string>()) : "";
}

// Returns an object in the status; an empty one if it is null.
Json object_in(const Json& status, const char* key) {
  const auto found = status.find(key);
  return found != status.end() && found->is_object() ? *found : Json::object();
}

Json number_in(const Json& object, const char* key) {
  const auto found = object.find(key);
  return found != object.end() && found->is_number() ? *found : Json();
}

// Returns why the printer needs its owner; empty if it does not.
std::string problem_in(const Json& status, const Json& job) {
  if (const std::string why = text_in(job, "interruption"); !why.empty()) return why;
  for (const char* key : {"not_ready_reason", "held"})
    if (const std::string why = text_in(status, key); !why.empty()) return why;
  const Json interrupted = object_in(status, "interrupted");
  return interrupted.empty() ? ""
                             : fmt::format("the print of {} was interrupted", text_in(interrupted, "job"));
}

// Returns the part of the layers that are exposed, in %, to a tenth.
Json progress_in(const Json& job) {
  const Json done = number_in(job, "layers_done"), layers = number_in(job, "layers");
  if (done.is_null() || layers.is_null() || layers.get<double>() <= 0) return {};
  constexpr double kPercent = 100, kTenth = 10;
  return std::min(kPercent,
                  std::round(kPercent * kTenth * done.get<double>() / layers.get<double>()) / kTenth);
}

// Returns the time left to 10 s, so that it does not change with each message.
Json time_left_in(const Json& job) {
  constexpr double kStepS = 10;
  const Json left = number_in(job, "time_left_s");
  return left.is_null() ? Json() : Json(std::lround(left.get<double>() / kStepS) * std::lround(kStepS));
}

}  // namespace

HomeAssistantTopics::HomeAssistantTopics(const HomeAssistantDevice& device)
    : discovery(fmt::format("{}/device/{}/config", device.prefix, device.id)),
      birth(fmt::format("{}/status", device.prefix)),
      state(fmt::format("contourd/{}/state", device.id)),
      availability(fmt::format("contourd/{}/availability", device.id)),
      picture(fmt::format("contourd/{}/mask", device.id)),
      commands(fmt::format("contourd/{}/command/", device.id)) {}

Json discovery_of(const HomeAssistantDevice& device, const std::string& printer) {
  const HomeAssistantTopics topics(device);
  Json about{{"ids", {device.id}},
             {"name", printable(printer)},
             {"mf", "contourd"},
             {"mdl", "resin printer"},
             {"sw", device.version}};
  if (!device.page.empty()) about["cu"] = device.page;
  Json all = components(topics);
  for (const auto& [key, component] : all.items())
    component["unique_id"] = fmt::format("{}_{}", device.id, key);
  return {{"dev", about},
          {"o", {{"name", "contourd"}, {"sw", device.version}}},
          {"stat_t", topics.state},
          {"avty_t", topics.availability},
          {"cmps", all}};
}

Json state_of(const Json& status, const HomeAssistantExtras& extras) {
  const Json job = object_in(status, "job"), last = object_in(status, "last");
  const std::string problem = problem_in(status, job);
  constexpr double kTenth = 10;
  return {{"state", group_of(text_in(status, "state"))},
          {"job", text_or_null(text_in(job, "name"))},
          {"progress", progress_in(job)},
          {"layer", number_in(job, "layer")},
          {"layers", number_in(job, "layers")},
          {"time_left_s", time_left_in(job)},
          {"resin_ml", extras.resin_ml ? Json(std::round(*extras.resin_ml * kTenth) / kTenth) : Json()},
          {"problem", problem.empty() ? "OFF" : "ON"},
          {"why", text_or_null(problem)},
          {"plate", text_in(status, "plate") == "occupied" ? "ON" : "OFF"},
          {"waiting_for", text_or_null(text_in(status, "waiting_for"))},
          {"queued", number_in(status, "queued")},
          {"last_job", text_or_null(text_in(last, "job"))},
          {"outcome", text_or_null(text_in(last, "outcome"))},
          {"outcome_reason", text_or_null(text_in(last, "reason"))},
          {"refused", text_or_null(extras.refused)}};
}

std::string_view method_of(const HomeAssistantTopics& topics, std::string_view topic) {
  if (!topic.starts_with(topics.commands)) return {};
  const auto* const button =
      std::ranges::find(kButtons, topic.substr(topics.commands.size()), &Button::method);
  return button == kButtons.end() ? std::string_view() : button->method;
}

}  // namespace contourd::web
