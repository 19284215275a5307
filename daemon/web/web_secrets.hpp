// The secrets of the web page: the hashes of the passwords that people enter, and the key that slicers send.
// Thread-safe (no shared state).
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "daemon/web/page/role.hpp"

namespace contourd::web {

struct WebSecrets {
  std::string password_hash;  // of the role print: crypt(5), yescrypt
  std::string key;            // random, in hexadecimal digits
  // Hashes of further roles; empty if they have no password.
  std::string watch_hash{}, service_hash{};

  [[nodiscard]] const std::string& hash_of(Role role) const {
    return role == Role::Watch ? watch_hash : role == Role::Service ? service_hash : password_hash;
  }
};

inline constexpr std::size_t kShortestPassword = 8, kLongestPassword = 256;

// Returns a sentence about a password that is too short, too long or has control characters; empty for a good
// one.
[[nodiscard]] std::string why_bad_password(std::string_view password);

// Returns the yescrypt hash of the password with a random salt. Takes some 10 ms and 16 MiB of memory. Throws
// std::system_error.
[[nodiscard]] std::string hash_of(const std::string& password);
// True if this is the password of that hash. Takes as long as hash_of(); the comparison takes constant time.
[[nodiscard]] bool is_password(const std::string& password, const std::string& hash);

// Returns the highest role that has this password; nullopt if none has. Checks the password of each role.
[[nodiscard]] std::optional<Role> role_with(const std::string& password, const WebSecrets& secrets);

// Returns that number of random bytes, from the kernel, in hexadecimal digits. Throws std::system_error.
[[nodiscard]] std::string random_hex(std::size_t bytes);
// Compares in a time that depends on the lengths only.
[[nodiscard]] bool equal_in_constant_time(std::string_view a, std::string_view b);

// Reads the secrets. Throws std::runtime_error with a sentence: no such file, not a file of secrets, or
// readable by other users.
[[nodiscard]] WebSecrets read_secrets(const std::filesystem::path& file);
// Writes the secrets into a file that only its owner can read, and replaces an earlier one. Blocks until it
// is on the disk. Throws std::system_error.
void write_secrets(const std::filesystem::path& file, const WebSecrets& secrets);

}  // namespace contourd::web
