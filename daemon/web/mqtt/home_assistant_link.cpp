#include "daemon/web/mqtt/home_assistant_link.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "daemon/system/readable.hpp"

namespace contourd::web {
namespace {

constexpr std::string_view kHomeName = "messages for Home Assistant";

std::string text_of(const nlohmann::ordered_json& json) {
  return json.dump(-1, ' ', true, nlohmann::ordered_json::error_handler_t::replace);
}

}  // namespace

HomeAssistantLink::HomeAssistantLink(EventLoop& loop, const Log& log, const MqttSettings& broker,
                                     const std::filesystem::path& socket, HomeAssistantDevice device)
    : loop_(loop),
      log_(log),
      device_(std::move(device)),
      topics_(device_),
      contourd_(loop, socket),
      mask_(contourd_),
      watch_(loop, socket, [this](const Json& status) { tell(status); }),
      broker_(loop, log, broker,
              {.client = device_.id,
               .will = {topics_.availability, std::string(kOffline)},
               .topics = {topics_.birth, topics_.commands + "+"}},
              {.connected =
                   [this] {
                     published_ = {};
                     publish();
                   },
               .received = [this](const MqttMessage& message) { receive(message); },
               .has_room = [this] { publish(); }}) {
  watch_.start();
}

HomeAssistantLink::~HomeAssistantLink() {
  broker_.publish_last(topics_.availability, kOffline, Retained::Yes);
}

void HomeAssistantLink::tell(const Json& status) {
  status_ = status.contains("unreachable") ? Json() : status;
  if (!status_.is_null()) printer_ = status_.value("printer", "");
  publish();
}

bool HomeAssistantLink::renew(std::string& latest, const std::string& topic, std::string text) {
  if (text == latest) return true;
  if (!broker_.has_room()) return false;
  broker_.publish(topic, text, Retained::Yes);
  latest = std::move(text);
  return true;
}

void HomeAssistantLink::publish() {
  if (!broker_.has_room()) return;
  const bool is_reachable = !status_.is_null();
  if (is_reachable && !publish_discovery()) return;
  if (is_reachable && !publish_state()) return;
  if (!renew(published_.availability, topics_.availability, std::string(is_reachable ? kOnline : kOffline)))
    return;
  if (!is_reachable) return;
  ask_for_resin();
  publish_picture();
}

bool HomeAssistantLink::publish_discovery() {
  if (published_.printer == printer_) return true;
  if (!broker_.has_room()) return false;
  broker_.publish(topics_.discovery, text_of(discovery_of(device_, printer_)), Retained::Yes);
  published_.printer = printer_;
  return true;
}

bool HomeAssistantLink::publish_state() {
  const Time now = std::chrono::steady_clock::now();
  std::string state = text_of(state_of(status_, extras_));
  if (state == published_.state) return true;
  if (now < next_.state) {
    timer_ = loop_.at(next_.state, kHomeName, [this] { publish(); });
    return true;
  }
  if (!renew(published_.state, topics_.state, std::move(state))) return false;
  next_.state = now + kStatePause;
  return true;
}

void HomeAssistantLink::publish_picture() {
  const Time now = std::chrono::steady_clock::now();
  const auto job = status_.find("job");
  if (job == status_.end() || !job->is_object() || !job->contains("layer") || now < next_.picture) return;
  const Json layer = (*job)["layer"];
  if (layer == published_.layer) return;
  next_.picture = now + kPicturePause;
  mask_.fetch([this, layer](const std::string& png, const Json&) {
    // The broker must not keep the picture: after the print no one would remove it.
    if (png.empty() || png.size() > kMostPictureBytes || !broker_.has_room()) return;
    broker_.publish(topics_.picture, png, Retained::No);
    published_.layer = layer;
  });
}

void HomeAssistantLink::ask_for_resin() {
  const Time now = std::chrono::steady_clock::now();
  if (now < next_.resin) return;
  next_.resin = now + kResinPause;
  contourd_.call({"vat"}, [this](const Json& answer) {
    const auto vat = answer.find("result");
    const bool is_known = vat != answer.end() && vat->contains("ml") && (*vat)["ml"].is_number();
    extras_.resin_ml = is_known ? std::optional((*vat)["ml"].get<double>()) : std::nullopt;
    publish();
  });
}

void HomeAssistantLink::receive(const MqttMessage& message) {
  if (message.topic == topics_.birth) {
    const Time now = std::chrono::steady_clock::now();
    if (message.payload != kOnline || now < next_.birth) return;
    next_.birth = now + kBirthPause;
    next_.picture = {};
    published_ = {};
    return publish();
  }
  const std::string_view method = method_of(topics_, message.topic);
  if (!method.empty() && message.payload == kPress) command(method);
}

void HomeAssistantLink::command(std::string_view method) {
  if (!is_allowed()) {
    const Time now = std::chrono::steady_clock::now();
    if (now < next_.warning) return;
    next_.warning = now + std::chrono::minutes(1);
    return log_.warning("mqtt", "commands arrive by MQTT faster than one a second; some are ignored");
  }
  log_.info("command", fmt::format("{} by MQTT", method));
  contourd_.call({std::string(method)}, [this, method](const Json& answer) {
    extras_.refused.clear();
    if (answer.contains("error")) {
      extras_.refused = printable(answer["error"].value("message", "contourd refuses"));
      log_.warning("command", fmt::format("{} by MQTT was refused: {}", method, extras_.refused));
    }
    publish();
  });
}

bool HomeAssistantLink::is_allowed() {
  const Time now = std::chrono::steady_clock::now();
  const std::chrono::duration<double> passed = now - std::exchange(allowance_.since, now);
  allowance_.commands = std::min<double>(kMostCommands, allowance_.commands + passed.count());
  if (allowance_.commands < 1) return false;
  allowance_.commands -= 1;
  return true;
}

}  // namespace contourd::web
