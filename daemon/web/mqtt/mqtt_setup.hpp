// The command that sets the MQTT broker: contourctl web mqtt.
#pragma once

#include <string>

#include "daemon/web/mqtt/mqtt_settings.hpp"

namespace contourd::web {

inline constexpr const char* kDefaultServiceUnit = "/etc/systemd/system/contourd-web.service.d";

struct MqttRequest {
  std::string broker;  // HOST or HOST:PORT; empty: show the present one
  std::string user, ca_file, prefix = kDefaultPrefix;
  bool off = false;
  std::string file = kDefaultMqttFile;
  std::string service_unit = kDefaultServiceUnit;  // folder of the unit's drop-ins
};

// Stores the broker and lets the service reach a network; asks for the password if there is a user. Without a
// broker, prints the present one. `secrets_file` is the page's password, without which the service is off.
// Returns the exit code. Throws std::runtime_error with a sentence for a setting that cannot be right.
int set_mqtt(const MqttRequest& request, const std::string& secrets_file);

}  // namespace contourd::web
