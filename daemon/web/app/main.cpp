// contourd-web: the printer's web page, a client of contourd.
#include <fmt/format.h>
#include <signal.h>
#include <systemd/sd-id128.h>

#include <CLI/CLI.hpp>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "daemon/json/config_error.hpp"
#include "daemon/system/command_line.hpp"
#include "daemon/system/event_loop.hpp"
#include "daemon/system/log.hpp"
#include "daemon/system/readable.hpp"
#include "daemon/system/standard_output.hpp"
#include "daemon/system/supervisor.hpp"
#include "daemon/web/announcement.hpp"
#include "daemon/web/hosts/host_printer.hpp"
#include "daemon/web/hosts/nanodlp_host.hpp"
#include "daemon/web/hosts/odyssey_host.hpp"
#include "daemon/web/listen_sockets.hpp"
#include "daemon/web/mqtt/home_assistant_link.hpp"
#include "daemon/web/mqtt/mqtt_settings.hpp"
#include "daemon/web/mqtt/mqtt_setup.hpp"
#include "daemon/web/web_config.hpp"
#include "daemon/web/web_secrets.hpp"
#include "daemon/web/web_service.hpp"
#include "daemon/web/web_setup.hpp"

namespace contourd::web {
namespace {

constexpr int kFailed = 70, kBadConfig = 78;

struct Arguments {
  std::string config = kDefaultWebConfig;
  WebFiles files;
  std::vector<std::string> listen;
  bool set_password = false, set_addresses = false, turn_off = false;
  std::string role{name_of(Role::Print)};
  bool remove = false;
  std::vector<std::string> addresses;
  bool set_mqtt = false;
  MqttRequest mqtt;
};

// Returns a name of this computer that stays the same, for Home Assistant. Throws std::system_error.
std::string device_id() {
  constexpr int kBytes = 8;
  constexpr sd_id128_t kApplication{.bytes = {0x5e, 0x0c, 0x8f, 0x1b, 0x6a, 0x3d, 0x4e, 0x57, 0x9a, 0x21,
                                              0xc4, 0x70, 0xd2, 0x9b, 0x36, 0xe8}};
  sd_id128_t id{};
  const int failed = ::sd_id128_get_machine_app_specific(kApplication, &id);
  if (failed < 0) throw std::system_error(-failed, std::generic_category(), "/etc/machine-id");
  std::string text = "contourd_";
  for (int i = 0; i < kBytes; ++i)
    text += fmt::format("{:02x}", id.bytes[i]);
  return text;
}

// The sockets of the service, by what they serve.
struct Sockets {
  std::vector<FileDescriptor> page, nanodlp, odyssey;
};

// Returns the sockets of the service manager and of --listen. Throws std::runtime_error.
Sockets open_sockets(const Arguments& args, const WebConfig& config) {
  std::vector<FileDescriptor> all = passed_sockets();
  if (all.empty() && args.listen.empty()) all.push_back(listen_on(kDefaultAddress));
  for (const std::string& address : args.listen)
    all.push_back(listen_on(address));
  Sockets sockets;
  for (FileDescriptor& socket : all) {
    const auto is_of = [port = port_of(socket)](const std::optional<HostPort>& host) {
      return host && host->port == port;
    };
    std::vector<FileDescriptor>& place = is_of(config.nanodlp)   ? sockets.nanodlp
                                         : is_of(config.odyssey) ? sockets.odyssey
                                                                 : sockets.page;
    place.push_back(std::move(socket));
  }
  return sockets;
}

// Warns of an interface on whose port nothing listens.
void check_sockets(const Log& log, const char* key, const std::optional<HostPort>& host,
                   const std::vector<FileDescriptor>& sockets) {
  if (!host || !sockets.empty()) return;
  log.warning("not_served",
              fmt::format("{} of web.json has the port {}, on which nothing listens: add it with "
                          "contourctl web addresses",
                          key, host->port));
}

int run(const Arguments& args) {
  const WebConfig config = load_web_config(args.config);
  WebSecrets secrets;
  std::optional<MqttSettings> mqtt;
  try {
    secrets = read_secrets(args.files.secrets);
    mqtt = read_mqtt(args.mqtt.file);
  } catch (const std::exception& error) {
    fmt::print(stderr, "contourd-web: {}\n", error.what());
    return kBadConfig;
  }
  EventLoop loop;
  ::signal(SIGPIPE, SIG_IGN);
  const auto terminated = loop.on_signal(SIGTERM, [&] { loop.stop(); });
  const auto interrupted = loop.on_signal(SIGINT, [&] { loop.stop(); });
  const Log log(loop);
  Supervisor supervisor(loop);
  Sockets sockets = open_sockets(args, config);
  check_sockets(log, "nanodlp", config.nanodlp, sockets.nanodlp);
  check_sockets(log, "odyssey", config.odyssey, sockets.odyssey);
  if (sockets.page.empty())
    log.warning(
        "not_served",
        "the page has no address, since web.json gives the ports of all to nanodlp and odyssey: add an "
        "address with another port with contourctl web addresses");
  const std::vector<std::string> pages = pages_at(addresses_of(sockets.page));
  const auto access = [&config](const HostPort& host) {
    HostAccess made{.clients = host.clients, .names = own_names()};
    made.names.insert(made.names.end(), config.names.begin(), config.names.end());
    return made;
  };
  std::optional<HostPrinter> printer;
  if (!sockets.nanodlp.empty() || !sockets.odyssey.empty()) printer.emplace(loop, log, config);
  std::unique_ptr<NanodlpHost> nanodlp;
  if (!sockets.nanodlp.empty())
    nanodlp = std::make_unique<NanodlpHost>(loop, *printer, access(*config.nanodlp), CONTOURD_VERSION,
                                            std::move(sockets.nanodlp));
  std::unique_ptr<OdysseyHost> odyssey;
  if (!sockets.odyssey.empty())
    odyssey = std::make_unique<OdysseyHost>(loop, *printer, access(*config.odyssey), CONTOURD_VERSION,
                                            std::move(sockets.odyssey));
  std::unique_ptr<HomeAssistantLink> home;
  if (mqtt)
    home = std::make_unique<HomeAssistantLink>(loop, log, *mqtt, config.control_socket,
                                               HomeAssistantDevice{.id = device_id(),
                                                                   .version = CONTOURD_VERSION,
                                                                   .page = pages.empty() ? "" : pages.front(),
                                                                   .prefix = mqtt->prefix});
  const WebService service(loop, log, config, std::move(secrets), own_names(), std::move(sockets.page));
  supervisor.ready();
  loop.run();
  return EXIT_SUCCESS;
}

int set_password_of(Role role, const Arguments& args) {
  if (role != Role::Print) return set_role_password(role, args.remove, args.files);
  if (args.remove)
    throw std::runtime_error(
        "the password of the role print cannot be removed alone: contourctl web off turns the page off");
  return set_password(args.files);
}

int start(int argc, char** argv) {
  CLI::App app{"Serves the web page of a printer that contourd runs."};
  app.set_version_flag("--version", CONTOURD_VERSION);
  Arguments args;
  app.add_option("--config", args.config, "Settings of the page")->capture_default_str();
  CLI::Option* const role =
      app.add_option("--role", args.role, "Role of the password for --set-password: watch, print or service")
          ->capture_default_str()
          ->check(CLI::IsMember({"watch", "print", "service"}));
  CLI::Option* const remove =
      app.add_flag("--remove", args.remove, "Remove the password of the role instead")->needs(role);
  app.add_option("--password-file", args.files.secrets, "Password and key")->capture_default_str();
  app.add_option("--listen", args.listen, "Listen on ADDRESS:PORT, too; several possible");
  CLI::Option* const password =
      app.add_flag("--set-password", args.set_password, "Set the password, and exit");
  CLI::Option* const addresses = app.add_flag("--set-addresses", args.set_addresses,
                                              "Set the addresses on which the service listens, and exit");
  app.add_option("--address", args.addresses, "ADDRESS:PORT for --set-addresses; several possible")
      ->needs(addresses);
  app.add_option("--socket-unit", args.files.socket_unit, "Folder for the addresses")->capture_default_str();
  CLI::Option* const off = app.add_flag("--turn-off", args.turn_off, "Remove the password, and exit");
  app.add_option("--avahi-service", args.files.announcement, "File from which avahi announces the page")
      ->capture_default_str();
  CLI::Option* const mqtt =
      app.add_flag("--set-mqtt", args.set_mqtt, "Set or show the MQTT broker, and exit");
  app.add_option("--mqtt-file", args.mqtt.file, "Settings of the MQTT broker")->capture_default_str();
  app.add_option("--broker", args.mqtt.broker, "HOST or HOST:PORT for --set-mqtt")->needs(mqtt);
  app.add_option("--user", args.mqtt.user, "User at the broker, whose password is asked for")->needs(mqtt);
  app.add_option("--ca", args.mqtt.ca_file, "Connect by TLS; FILE: certificate of the broker's CA")
      ->needs(mqtt);
  app.add_option("--prefix", args.mqtt.prefix, "Prefix of Home Assistant's topics")
      ->capture_default_str()
      ->needs(mqtt);
  app.add_flag("--off", args.mqtt.off, "Use no broker")->needs(mqtt);
  app.add_option("--service-unit", args.mqtt.service_unit, "Folder for the service's right to a network")
      ->capture_default_str();
  role->needs(password);
  remove->needs(password);
  password->excludes(addresses)->excludes(mqtt)->excludes(off);
  addresses->excludes(mqtt)->excludes(off);
  mqtt->excludes(off);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return end_of_command_line(app, error);
  }
  if (args.set_password || args.set_addresses) {
    const WebConfig config = load_web_config(args.config);
    for (const std::optional<HostPort>& host : {config.nanodlp, config.odyssey})
      if (host) args.files.host_ports.push_back(host->port);
  }
  if (args.set_password) return set_password_of(*role_of(args.role), args);
  if (args.set_addresses) return set_addresses(args.addresses, args.files);
  if (args.turn_off) return turn_off(args.files);
  if (args.set_mqtt) return set_mqtt(args.mqtt, args.files.secrets);
  return run(args);
}

}  // namespace
}  // namespace contourd::web

int main(int argc, char** argv) {
  const auto complain = [](int code, const std::string& why) {
    fmt::print(stderr, "contourd-web: {}\n", why);
    return code;
  };
  try {
    return contourd::print_whole([&] { return contourd::web::start(argc, argv); });
  } catch (const contourd::ConfigError& error) {
    return complain(contourd::web::kBadConfig, error.what());
  } catch (const contourd::OutputError& error) {
    return complain(contourd::kCannotCreate, error.what());
  } catch (const std::exception& error) {
    return complain(contourd::web::kFailed, contourd::printable(error.what()));
  }
}
