#include <filesystem>
#include <stdexcept>
#include <string>
#include <system_error>
#include <vector>

#include "daemon/ctl/commands/commands.hpp"
#include "daemon/ctl/terminal/program.hpp"

namespace contourd::ctl {
namespace {

namespace fs = std::filesystem;

constexpr const char* kWebProgram = "contourd-web";

// Returns the program of the web page: beside this program, or else by PATH.
std::string web_program() {
  std::error_code error;
  const fs::path beside = fs::read_symlink("/proc/self/exe", error).parent_path() / kWebProgram;
  return !error && fs::exists(beside, error) ? beside.string() : kWebProgram;
}

// The web page's program does the work, so that contourctl needs none of its libraries.
[[noreturn]] void become_web_program(std::vector<std::string> options) {
  options.insert(options.begin(), web_program());
  try {
    become_program(options);
  } catch (const std::system_error& error) {
    if (error.code() != std::errc::no_such_file_or_directory) throw;
    throw std::runtime_error("the printer's web page is not installed: install the package contourd-web");
  }
}

struct PasswordArguments {
  std::string role;
  bool remove = false;
};

struct MqttArguments {
  std::string broker, user, prefix;
  fs::path ca_file;
  bool off = false;
};

void add_mqtt(Command& web) {
  Command& mqtt = web.add("mqtt", "Show or set the MQTT broker by which Home Assistant sees the printer");
  auto& given = mqtt.arguments<MqttArguments>();
  const Option& broker =
      mqtt.option("BROKER", given.broker, "HOST or HOST:PORT, such as homeassistant.local");
  mqtt.option("--user", given.user, "User at the broker; the password is asked for").needs(broker);
  mqtt.option("--ca", given.ca_file, "Connect by TLS; FILE: certificate of the broker's CA").needs(broker);
  mqtt.option("--prefix", given.prefix, "Prefix of Home Assistant's topics").needs(broker);
  mqtt.option("--off", given.off, "Use no broker").excludes(broker);
  mqtt.run = [&given]() -> int {
    std::vector<std::string> options{"--set-mqtt"};
    const auto add = [&options](const char* option, const std::string& value) {
      if (!value.empty()) options.insert(options.end(), {option, value});
    };
    add("--broker", given.broker);
    add("--user", given.user);
    add("--ca", given.ca_file.string());
    add("--prefix", given.prefix);
    if (given.off) options.emplace_back("--off");
    become_web_program(options);
  };
}

}  // namespace

void add_web(Command& program) {
  Command& web = program.add("web", "Set up the printer's web page");
  Command& password = web.add("password", "Set the page's password, and make a new key for slicers");
  auto& asked = password.arguments<PasswordArguments>();
  const Option& role =
      password.option("--role", asked.role, "Set the password of this role, by default print")
          .one_of({"watch", "print", "service"});
  password.option("--remove", asked.remove, "Remove the password of the role").needs(role);
  password.run = [&asked]() -> int {
    std::vector<std::string> options{"--set-password"};
    if (!asked.role.empty()) options.insert(options.end(), {"--role", asked.role});
    if (asked.remove) options.emplace_back("--remove");
    become_web_program(options);
  };
  Command& addresses = web.add("addresses", "Show or set the addresses on which the page is served");
  auto& given = addresses.arguments<std::vector<std::string>>();
  addresses.option("ADDRESS", given, "ADDRESS:PORT, such as 192.168.1.20:8080; several possible");
  addresses.run = [&given]() -> int {
    std::vector<std::string> options{"--set-addresses"};
    for (const std::string& each : given)
      options.insert(options.end(), {"--address", each});
    become_web_program(options);
  };
  add_mqtt(web);
  Command& off = web.add("off", "Remove the page's password, without which there is no page");
  off.run = []() -> int { become_web_program({"--turn-off"}); };
}

}  // namespace contourd::ctl
