// The printer as Home Assistant knows it: the document of MQTT discovery (device-based, since 2024.11), the
// state, the topics and the commands. Thread-safe (no state).
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>

namespace contourd::web {

struct HomeAssistantDevice {
  std::string id;       // letters, digits and "_"; the same after each start
  std::string version;  // contourd's
  std::string page;     // URL of the printer's page; empty: only this computer can open it
  std::string prefix;   // begins Home Assistant's topics
};

struct HomeAssistantTopics {
  explicit HomeAssistantTopics(const HomeAssistantDevice& device);

  std::string discovery, birth;  // Home Assistant publishes "online" to `birth` when it starts
  std::string state, availability, picture;
  std::string commands;  // ends in "/", and a method of contourd follows
};

inline constexpr std::string_view kOnline = "online", kOffline = "offline", kPress = "PRESS";

// Returns the document for the topic `discovery`. `printer` is the printer's name.
[[nodiscard]] nlohmann::ordered_json discovery_of(const HomeAssistantDevice& device,
                                                  const std::string& printer);

// Parts of the state that are not in contourd's status.
struct HomeAssistantExtras {
  std::optional<double> resin_ml;  // in the vat
  std::string refused;             // why contourd has refused the last command; empty if it has not
};
// Returns the state for the topic `state`. `status` is contourd's answer to the method of this name.
[[nodiscard]] nlohmann::ordered_json state_of(const nlohmann::ordered_json& status,
                                              const HomeAssistantExtras& extras);

// Returns the method of contourd that a command's topic names; empty for any other topic.
[[nodiscard]] std::string_view method_of(const HomeAssistantTopics& topics, std::string_view topic);

}  // namespace contourd::web
