#include "daemon/web/mqtt/mqtt_settings.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cstddef>
#include <stdexcept>
#include <string_view>
#include <system_error>

#include "daemon/system/readable.hpp"
#include "daemon/system/regular_file.hpp"
#include "daemon/system/secret_file.hpp"

namespace contourd::web {
namespace {

namespace fs = std::filesystem;

constexpr int kPlainPort = 1883, kTlsPort = 8883, kLargestPort = 65535;
constexpr std::size_t kLongestHost = 253, kLongestText = 256, kLongestPrefix = 64, kLongestFile = 1024;
constexpr std::string_view kLetters = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789";

[[noreturn]] void refuse(std::string_view what, std::string_view wanted) {
  throw std::runtime_error(fmt::format("{}: expected {}", printable(shortened(what, 100)), wanted));
}

// True if each character is a letter, a digit or one of `others`.
bool consists_of(std::string_view text, std::string_view others) {
  return std::ranges::all_of(text, [others](char letter) {
    return kLetters.find(letter) != std::string_view::npos || others.find(letter) != std::string_view::npos;
  });
}

bool fits_a_line(std::string_view text) {
  const auto is_control = [](char letter) { return static_cast<unsigned char>(letter) < ' '; };
  return text.size() <= kLongestText && std::ranges::none_of(text, is_control);
}

int port_of(std::string_view text) {
  int port = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), port);
  return error == std::errc() && end == text.data() + text.size() ? port : 0;
}

}  // namespace

void set_broker(MqttSettings& settings, const std::string& broker) {
  constexpr std::string_view kWanted = "a broker such as homeassistant.local or 192.168.1.5:1883";
  std::string_view rest = broker;
  settings.port = settings.ca_file.empty() ? kPlainPort : kTlsPort;
  const std::size_t bracket = rest.starts_with('[') ? rest.find(']') : std::string_view::npos;
  const bool is_bare_ipv6 = bracket == std::string_view::npos && std::ranges::count(rest, ':') > 1;
  const std::size_t colon =
      is_bare_ipv6 ? std::string_view::npos : rest.find(':', bracket == std::string_view::npos ? 0 : bracket);
  if (colon != std::string_view::npos) {
    settings.port = port_of(rest.substr(colon + 1));
    rest = rest.substr(0, colon);
  }
  if (bracket != std::string_view::npos) {
    if (bracket + 1 != rest.size()) refuse(broker, kWanted);
    rest = rest.substr(1, bracket - 1);
  }
  settings.host = rest;
  if (settings.port == 0) refuse(broker, kWanted);
}

std::string broker_of(const MqttSettings& settings) {
  const bool is_ipv6 = settings.host.find(':') != std::string::npos;
  return fmt::format("{}{}{}:{}", is_ipv6 ? "[" : "", settings.host, is_ipv6 ? "]" : "", settings.port);
}

void check_mqtt(const MqttSettings& settings) {
  if (settings.host.empty() || settings.host.size() > kLongestHost || settings.host.starts_with('-') ||
      !consists_of(settings.host, ".-_:"))
    refuse(settings.host, "the name or the address of an MQTT broker");
  if (settings.port < 1 || settings.port > kLargestPort)
    refuse(fmt::format("port {}", settings.port), fmt::format("a port from 1 to {}", kLargestPort));
  if (!fits_a_line(settings.user))
    refuse("user", fmt::format("at most {} bytes without control characters", kLongestText));
  if (!fits_a_line(settings.password))
    refuse("password", fmt::format("at most {} bytes without control characters", kLongestText));
  if (settings.user.empty() && !settings.password.empty()) refuse("password", "a user, too");
  if (!settings.ca_file.empty() &&
      (!settings.ca_file.starts_with('/') || settings.ca_file.size() > kLongestFile ||
       settings.ca_file.find('\n') != std::string::npos))
    refuse(settings.ca_file, "the absolute path of a file with certificates");
  if (settings.prefix.empty() || settings.prefix.size() > kLongestPrefix ||
      !consists_of(settings.prefix, "_-/") || settings.prefix.starts_with('/') ||
      settings.prefix.ends_with('/'))
    refuse(settings.prefix, "a topic of letters, digits, \"_\", \"-\" and \"/\", such as homeassistant");
}

std::optional<MqttSettings> read_mqtt(const fs::path& file) {
  std::error_code error;
  if (!fs::exists(file, error) && !error) return std::nullopt;
  std::string text;
  try {
    text = read_secret_file(file);
    MqttSettings settings{.host = secret_value(text, "broker"),
                          .port = port_of(secret_value(text, "port")),
                          .user = secret_value(text, "user"),
                          .password = secret_value(text, "password"),
                          .ca_file = secret_value(text, "ca"),
                          .prefix = secret_value(text, "prefix")};
    check_mqtt(settings);
    return settings;
  } catch (const UnreadableFile& unreadable) {
    throw std::runtime_error(fmt::format("{}: {}", printable(file.string()), unreadable.what()));
  } catch (const std::runtime_error& wrong) {
    const std::string why = wrong.what();
    if (why.starts_with(file.string())) throw;
    throw std::runtime_error(fmt::format("{}: {}; set the broker again: sudo contourctl web mqtt BROKER",
                                         printable(file.string()), why));
  }
}

void write_mqtt(const fs::path& file, const MqttSettings& settings) {
  std::string text =
      fmt::format("broker {}\nport {}\nprefix {}\n", settings.host, settings.port, settings.prefix);
  if (!settings.user.empty()) text += fmt::format("user {}\n", settings.user);
  if (!settings.password.empty()) text += fmt::format("password {}\n", settings.password);
  if (!settings.ca_file.empty()) text += fmt::format("ca {}\n", settings.ca_file);
  write_secret_file(file, text);
}

}  // namespace contourd::web
