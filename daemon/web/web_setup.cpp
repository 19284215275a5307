#include "daemon/web/web_setup.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <optional>
#include <stdexcept>
#include <system_error>

#include "daemon/system/readable.hpp"
#include "daemon/system/standard_output.hpp"
#include "daemon/web/listen_sockets.hpp"
#include "daemon/web/qr_code.hpp"
#include "daemon/web/setup/prompt.hpp"
#include "daemon/web/setup/setting_file.hpp"
#include "daemon/web/web_secrets.hpp"

namespace contourd::web {
namespace {

namespace fs = std::filesystem;

constexpr int kBadData = 65;
constexpr const char* kPort = "8080";
constexpr const char* kDropIn = "addresses.conf";
constexpr std::string_view kListen = "ListenStream=";

// Returns the new password; nullopt if it was refused, with the reason on stderr.
std::optional<std::string> new_password() {
  std::optional<std::string> password = secret_after("New password for the printer's page: ");
  if (!password) return std::nullopt;
  const std::string why = why_bad_password(*password);
  if (why.empty()) return password;
  fmt::print(stderr, "contourctl: {}; nothing was changed\n", why);
  return std::nullopt;
}

// Returns the addresses of the drop-in file; the unit's own address if there is none.
std::vector<std::string> present_addresses(const std::string& socket_unit) {
  std::vector<std::string> addresses;
  std::ifstream file(fs::path(socket_unit) / kDropIn);
  for (std::string line; std::getline(file, line);)
    if (line.starts_with(kListen) && line.size() > kListen.size())
      addresses.push_back(line.substr(kListen.size()));
  return addresses.empty() ? std::vector<std::string>{kDefaultAddress} : addresses;
}

// Returns the secrets of the file; nullopt if it does not exist.
std::optional<WebSecrets> present_secrets(const std::string& file) {
  std::error_code error;
  if (!fs::exists(file, error)) return std::nullopt;
  try {
    return read_secrets(file);
  } catch (const std::runtime_error&) {
    return std::nullopt;  // no file of secrets: it is replaced
  }
}

// Returns the addresses at which there is a page.
std::vector<std::string> page_addresses(std::vector<std::string> addresses, const WebFiles& files) {
  std::erase_if(addresses, [&files](const std::string& address) {
    const std::string port = address.substr(address.rfind(':') + 1);
    return std::ranges::any_of(files.host_ports, [&port](int each) { return std::to_string(each) == port; });
  });
  return addresses;
}

void store(const WebSecrets& secrets, const std::string& file) {
  try {
    write_secrets(file, secrets);
  } catch (const std::system_error& error) {
    throw OutputError(
        fmt::format("{}: {}; run the command as root", printable(file), error.code().message()));
  }
}

int refuse_shared_password() {
  fmt::print(stderr, "contourctl: another role has this password; nothing was changed\n");
  return kBadData;
}

void write_addresses(const std::vector<std::string>& addresses, const fs::path& folder) {
  std::string text =
      "# Written by contourctl web. FreeBind: an address may come later than the service.\n[Socket]\n";
  text += fmt::format("{}\n", kListen);
  for (const std::string& address : addresses)
    text += fmt::format("{}{}\n", kListen, address);
  text += "FreeBind=yes\n";
  write_setting(folder / kDropIn, text);
}

void say_how_to_start() {
  fmt::print(
      "Start the page with the new settings:\n"
      "    systemctl daemon-reload\n"
      "    systemctl stop contourd-web.service\n"
      "    systemctl restart contourd-web.socket\n");
}

// Prints the first address at which phones reach the page as a QR code, if the terminal can show one.
void show_page(const std::vector<std::string>& addresses) {
  const std::vector<std::string> pages = pages_at(addresses);
  if (pages.empty() || !can_show_qr_code()) return;
  fmt::print("{}\n{}\n", pages.front(), qr_code_of(pages.front()));
}

// Offers the addresses of the local network.
void ask_for_addresses(const std::string& socket_unit) {
  std::vector<std::string> addresses = present_addresses(socket_unit);
  const std::size_t before = addresses.size();
  for (const std::string& each : network_addresses()) {
    const std::string address = fmt::format("{}:{}", each, kPort);
    if (std::ranges::find(addresses, address) != addresses.end()) continue;
    const std::string question =
        fmt::format("Serve the page to this computer's network, too, on http://{}/? [y/N] ", address);
    const std::string answer = line_after(question.c_str());
    if (answer.starts_with('y') || answer.starts_with('Y')) addresses.push_back(address);
  }
  if (addresses.size() > before) write_addresses(addresses, socket_unit);
}

}  // namespace

int set_password(const WebFiles& files) {
  const std::optional<std::string> password = new_password();
  if (!password) return kBadData;
  constexpr std::size_t kKeyBytes = 16;
  WebSecrets secrets = present_secrets(files.secrets).value_or(WebSecrets{});
  secrets.password_hash.clear();
  if (role_with(*password, secrets)) return refuse_shared_password();
  secrets.password_hash = hash_of(*password);
  secrets.key = random_hex(kKeyBytes);
  store(secrets, files.secrets);
  fmt::print("The password is set. Key for slicers (PrusaSlicer: printer type SL1, API key): {}\n",
             secrets.key);
  if (on_terminal()) ask_for_addresses(files.socket_unit);
  const std::vector<std::string> addresses = page_addresses(present_addresses(files.socket_unit), files);
  announce(addresses, files.announcement);
  show_page(addresses);
  say_how_to_start();
  return EXIT_SUCCESS;
}

int set_role_password(Role role, bool remove, const WebFiles& files) {
  WebSecrets secrets = read_secrets(files.secrets);
  std::string& hash = role == Role::Watch ? secrets.watch_hash : secrets.service_hash;
  hash.clear();
  if (!remove) {
    const std::optional<std::string> password = new_password();
    if (!password) return kBadData;
    if (role_with(*password, secrets)) return refuse_shared_password();
    hash = hash_of(*password);
  }
  store(secrets, files.secrets);
  fmt::print("The password of the role {} is {}.\n", name_of(role), remove ? "removed" : "set");
  say_how_to_start();
  return EXIT_SUCCESS;
}

int set_addresses(const std::vector<std::string>& addresses, const WebFiles& files) {
  if (addresses.empty()) {
    const std::vector<std::string> present = present_addresses(files.socket_unit);
    fmt::print("{}\n", fmt::join(present, "\n"));
    show_page(page_addresses(present, files));
    return EXIT_SUCCESS;
  }
  for (const std::string& address : addresses)
    check_address(address);
  write_addresses(addresses, files.socket_unit);
  // Until a password is set, no page is there.
  std::error_code error;
  if (fs::exists(files.secrets, error)) announce(page_addresses(addresses, files), files.announcement);
  say_how_to_start();
  return EXIT_SUCCESS;
}

int turn_off(const WebFiles& files) {
  remove_setting(files.announcement);
  remove_setting(files.secrets);
  fmt::print(
      "Stop the page:\n"
      "    systemctl stop contourd-web.socket contourd-web.service\n");
  return EXIT_SUCCESS;
}

}  // namespace contourd::web
