// contourd-web: the printer's web page, a client of contourd.
#include <fmt/format.h>
#include <signal.h>

#include <CLI/CLI.hpp>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "daemon/json/config_error.hpp"
#include "daemon/system/command_line.hpp"
#include "daemon/system/event_loop.hpp"
#include "daemon/system/log.hpp"
#include "daemon/system/readable.hpp"
#include "daemon/system/standard_output.hpp"
#include "daemon/system/supervisor.hpp"
#include "daemon/web/listen_sockets.hpp"
#include "daemon/web/web_config.hpp"
#include "daemon/web/web_secrets.hpp"
#include "daemon/web/web_service.hpp"
#include "daemon/web/web_setup.hpp"

namespace contourd::web {
namespace {

constexpr int kFailed = 70, kBadConfig = 78;

struct Arguments {
  std::string config = kDefaultWebConfig, secrets = kDefaultSecrets;
  std::vector<std::string> listen;
  bool set_password = false, set_addresses = false;
  std::vector<std::string> addresses;
  std::string socket_unit = kDefaultSocketUnit;
};

int run(const Arguments& args) {
  const WebConfig config = load_web_config(args.config);
  WebSecrets secrets;
  try {
    secrets = read_secrets(args.secrets);
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
  std::vector<FileDescriptor> sockets = passed_sockets();
  if (sockets.empty() && args.listen.empty()) sockets.push_back(listen_on(kDefaultAddress));
  for (const std::string& address : args.listen)
    sockets.push_back(listen_on(address));
  const WebService service(loop, log, config, std::move(secrets), own_names(), std::move(sockets));
  supervisor.ready();
  loop.run();
  return EXIT_SUCCESS;
}

int start(int argc, char** argv) {
  CLI::App app{"Serves the web page of a printer that contourd runs."};
  app.set_version_flag("--version", CONTOURD_VERSION);
  Arguments args;
  app.add_option("--config", args.config, "Settings of the page")->capture_default_str();
  app.add_option("--password-file", args.secrets, "Password and key")->capture_default_str();
  app.add_option("--listen", args.listen, "Listen on ADDRESS:PORT, too; several possible");
  CLI::Option* const password =
      app.add_flag("--set-password", args.set_password, "Set the password, and exit");
  CLI::Option* const addresses = app.add_flag("--set-addresses", args.set_addresses,
                                              "Set the addresses on which the service listens, and exit");
  app.add_option("--address", args.addresses, "ADDRESS:PORT for --set-addresses; several possible")
      ->needs(addresses);
  app.add_option("--socket-unit", args.socket_unit, "Folder for the addresses")->capture_default_str();
  password->excludes(addresses);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return end_of_command_line(app, error);
  }
  if (args.set_password) return set_password(args.secrets, args.socket_unit);
  if (args.set_addresses) return set_addresses(args.addresses, args.socket_unit);
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
