// The MQTT broker to which contourd-web reports the printer. A value, kept in a file that only root can read.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

namespace contourd::web {

inline constexpr const char* kDefaultMqttFile = "/etc/contourd/web-mqtt";
inline constexpr const char* kDefaultPrefix = "homeassistant";

struct MqttSettings {
  std::string host{};  // a name or an address, without brackets
  int port = 0;
  std::string user{}, password{};       // empty: the broker takes anyone
  std::string ca_file{};                // PEM, absolute; empty: no TLS
  std::string prefix = kDefaultPrefix;  // begins Home Assistant's topics

  friend bool operator==(const MqttSettings&, const MqttSettings&) = default;
};

// Splits "HOST", "HOST:PORT" or "[IPV6]:PORT" into host and port; without a port, takes 8883 with TLS and
// 1883 without. Throws std::runtime_error with a sentence.
void set_broker(MqttSettings& settings, const std::string& broker);
// Returns the broker as HOST:PORT.
[[nodiscard]] std::string broker_of(const MqttSettings& settings);

// Throws std::runtime_error with a sentence about the first setting that cannot be right.
void check_mqtt(const MqttSettings& settings);

// Reads the settings; nullopt if there is no such file, which means that MQTT is off. Throws
// std::runtime_error with a sentence: unreadable, readable by other users, or wrong.
[[nodiscard]] std::optional<MqttSettings> read_mqtt(const std::filesystem::path& file);
// Writes the settings into a file that only its owner can read. Blocks until it is on the disk. Throws
// std::system_error.
void write_mqtt(const std::filesystem::path& file, const MqttSettings& settings);

}  // namespace contourd::web
