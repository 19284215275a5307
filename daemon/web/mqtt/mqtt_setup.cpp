#include "daemon/web/mqtt/mqtt_setup.hpp"

#include <fmt/format.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <stdexcept>
#include <system_error>

#include "daemon/system/readable.hpp"
#include "daemon/system/standard_output.hpp"
#include "daemon/web/setup/prompt.hpp"
#include "daemon/web/setup/setting_file.hpp"

namespace contourd::web {
namespace {

namespace fs = std::filesystem;

constexpr int kRefused = 65;
constexpr const char* kMqttDropIn = "mqtt.conf";

// Returns the drop-in that gives the service the settings, and a network to reach the broker. The service can
// then connect to others, but no one to it, except by the sockets that the manager has opened.
std::string drop_in_for(const fs::path& file) {
  return fmt::format(
      "# Written by contourctl web mqtt: the service may connect to the MQTT broker.\n"
      "[Service]\n"
      "LoadCredential=web-mqtt:{}\n"
      "PrivateNetwork=no\n"
      "RestrictAddressFamilies=AF_INET AF_INET6 AF_NETLINK\n"
      "SocketBindDeny=any\n",
      file.string());
}

void say_how_to_restart(std::string_view verb) {
  fmt::print(
      "Use the new setting:\n"
      "    systemctl daemon-reload\n"
      "    systemctl {} contourd-web.service\n"
      "    systemctl restart contourd-web.service\n",
      verb);
}

int show_mqtt(const std::string& file) {
  const std::optional<MqttSettings> settings = read_mqtt(file);
  if (!settings) {
    fmt::print("off\n");
    return EXIT_SUCCESS;
  }
  fmt::print("{}\n", broker_of(*settings));
  if (!settings->user.empty()) fmt::print("user {}\n", printable(settings->user));
  if (!settings->ca_file.empty()) fmt::print("TLS, certificates {}\n", printable(settings->ca_file));
  if (settings->prefix != kDefaultPrefix) fmt::print("prefix {}\n", settings->prefix);
  return EXIT_SUCCESS;
}

int turn_mqtt_off(const MqttRequest& request) {
  remove_setting(request.file);
  remove_setting(fs::path(request.service_unit) / kMqttDropIn);
  say_how_to_restart("disable");
  return EXIT_SUCCESS;
}

}  // namespace

int set_mqtt(const MqttRequest& request, const std::string& secrets_file) {
  if (request.off) return turn_mqtt_off(request);
  if (request.broker.empty()) return show_mqtt(request.file);
  MqttSettings settings{.user = request.user, .ca_file = request.ca_file, .prefix = request.prefix};
  set_broker(settings, request.broker);
  check_mqtt(settings);
  std::error_code error;
  if (!settings.ca_file.empty() && !fs::is_regular_file(settings.ca_file, error))
    throw std::runtime_error(
        fmt::format("{}: there is no such file with certificates", printable(settings.ca_file)));
  if (!settings.user.empty()) {
    const std::optional<std::string> password = secret_after("Password of this user at the MQTT broker: ");
    if (!password) return kRefused;
    settings.password = *password;
    check_mqtt(settings);
  }
  try {
    write_mqtt(request.file, settings);
  } catch (const std::system_error& failed) {
    throw OutputError(
        fmt::format("{}: {}; run the command as root", printable(request.file), failed.code().message()));
  }
  write_setting(fs::path(request.service_unit) / kMqttDropIn, drop_in_for(request.file));
  fmt::print("The printer reports to the MQTT broker {}.\n", broker_of(settings));
  if (!fs::exists(secrets_file, error))
    fmt::print("The service is off until a password is set for its page: sudo contourctl web password\n");
  say_how_to_restart("enable");
  return EXIT_SUCCESS;
}

}  // namespace contourd::web
