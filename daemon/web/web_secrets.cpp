#include "daemon/web/web_secrets.hpp"

#include <crypt.h>
#include <fmt/format.h>
#include <sys/random.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdlib>
#include <memory>
#include <stdexcept>
#include <system_error>
#include <vector>

#include "daemon/system/readable.hpp"
#include "daemon/system/regular_file.hpp"
#include "daemon/system/secret_file.hpp"

namespace contourd::web {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kHash = "password", kKey = "key", kWatch = "watch", kService = "service";
constexpr std::string_view kYescrypt = "$y$";
constexpr std::size_t kKeyDigits = 32;

std::vector<unsigned char> random_bytes(std::size_t count) {
  std::vector<unsigned char> bytes(count);
  for (std::size_t got = 0; got < count;) {
    const ssize_t more = ::getrandom(bytes.data() + got, count - got, 0);
    if (more < 0 && errno == EINTR) continue;
    if (more < 0) throw std::system_error(errno, std::generic_category(), "getrandom");
    got += static_cast<std::size_t>(more);
  }
  return bytes;
}

// Returns the crypt(3) hash of the password by that setting: a salt, or an earlier hash. Empty if crypt(3)
// fails.
std::string crypted(const std::string& password, const std::string& setting) {
  const auto data = std::make_unique<crypt_data>();
  const char* const hash =
      ::crypt_rn(password.c_str(), setting.c_str(), data.get(), static_cast<int>(sizeof(crypt_data)));
  std::string result = hash == nullptr ? "" : hash;
  ::explicit_bzero(data.get(), sizeof(crypt_data));
  return result;
}

bool is_key(std::string_view key) {
  return key.size() == kKeyDigits && key.find_first_not_of("0123456789abcdef") == std::string_view::npos;
}

}  // namespace

std::string why_bad_password(std::string_view password) {
  if (password.size() < kShortestPassword)
    return fmt::format("the password needs at least {} characters", kShortestPassword);
  if (password.size() > kLongestPassword)
    return fmt::format("the password may have at most {} bytes", kLongestPassword);
  const auto is_control = [](char letter) { return static_cast<unsigned char>(letter) < ' '; };
  return std::ranges::any_of(password, is_control) ? "the password must not contain control characters" : "";
}

std::string hash_of(const std::string& password) {
  constexpr unsigned long kDefaultCost = 0;
  const std::vector<unsigned char> random = random_bytes(16);
  std::array<char, CRYPT_GENSALT_OUTPUT_SIZE> salt{};
  if (::crypt_gensalt_rn(kYescrypt.data(), kDefaultCost, reinterpret_cast<const char*>(random.data()),
                         static_cast<int>(random.size()), salt.data(),
                         static_cast<int>(salt.size())) == nullptr)
    throw std::system_error(errno, std::generic_category(), "crypt_gensalt");
  std::string hash = crypted(password, salt.data());
  if (!hash.starts_with(kYescrypt)) throw std::system_error(errno, std::generic_category(), "crypt");
  return hash;
}

bool is_password(const std::string& password, const std::string& hash) {
  return hash.starts_with(kYescrypt) && why_bad_password(password).empty() &&
         equal_in_constant_time(crypted(password, hash), hash);
}

std::optional<Role> role_with(const std::string& password, const WebSecrets& secrets) {
  std::optional<Role> found;
  for (const Role role : kRoles)
    if (!secrets.hash_of(role).empty() && is_password(password, secrets.hash_of(role))) found = role;
  return found;
}

std::string random_hex(std::size_t bytes) {
  std::string text;
  for (const unsigned char byte : random_bytes(bytes))
    text += fmt::format("{:02x}", byte);
  return text;
}

bool equal_in_constant_time(std::string_view a, std::string_view b) {
  if (a.size() != b.size()) return false;
  unsigned difference = 0;
  for (std::size_t i = 0; i < a.size(); ++i)
    difference |= static_cast<unsigned char>(a[i]) ^ static_cast<unsigned>(static_cast<unsigned char>(b[i]));
  return difference == 0;
}

WebSecrets read_secrets(const fs::path& file) {
  const std::string name = printable(file.string());
  std::string text;
  try {
    text = read_secret_file(file);
  } catch (const UnreadableFile& error) {
    throw std::runtime_error(
        fmt::format("{}: {}; the web page is off until a password is set: sudo contourctl web password", name,
                    error.what()));
  }
  const WebSecrets secrets{.password_hash = secret_value(text, kHash),
                           .key = secret_value(text, kKey),
                           .watch_hash = secret_value(text, kWatch),
                           .service_hash = secret_value(text, kService)};
  const bool has_hashes = std::ranges::all_of(kRoles, [&secrets](Role role) {
    const std::string& hash = secrets.hash_of(role);
    return hash.starts_with(kYescrypt) || (hash.empty() && role != Role::Print);
  });
  if (!has_hashes || !is_key(secrets.key))
    throw std::runtime_error(
        fmt::format("{}: it is not a file of contourctl web password: run that command again", name));
  return secrets;
}

void write_secrets(const fs::path& file, const WebSecrets& secrets) {
  std::string text = fmt::format("{} {}\n{} {}\n", kHash, secrets.password_hash, kKey, secrets.key);
  if (!secrets.watch_hash.empty()) text += fmt::format("{} {}\n", kWatch, secrets.watch_hash);
  if (!secrets.service_hash.empty()) text += fmt::format("{} {}\n", kService, secrets.service_hash);
  write_secret_file(file, text);
}

}  // namespace contourd::web
