#include "daemon/ctl/commands/private_text.hpp"

#include <algorithm>
#include <array>
#include <cstddef>

namespace contourd::ctl {
namespace {

constexpr std::string_view kStruck = "***";
constexpr std::array<std::string_view, 8> kSecrets{"password", "passwd",     "passphrase", "token",
                                                   "secret",   "credential", "macaddr",    "key"};

bool is_letter(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
}
bool is_digit(char c) {
  return c >= '0' && c <= '9';
}

// Returns the text with ASCII capitals as small letters.
std::string in_small_letters(std::string_view text) {
  std::string small(text);
  std::ranges::transform(small, small.begin(),
                         [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
  return small;
}

// Returns the position of a secret's value: after its name, which may continue with other letters and quotes,
// and after ':' or '='. npos if there is none.
std::size_t secret_in(const std::string& line) {
  const std::string small = in_small_letters(line);
  std::size_t first = std::string::npos;
  for (const std::string_view word : kSecrets) {
    for (std::size_t at = small.find(word); at != std::string::npos; at = small.find(word, at + 1)) {
      std::size_t end = at + word.size();
      while (end < small.size() && (is_letter(small[end]) || is_digit(small[end]) ||
                                    std::string_view("_-\"' ").find(small[end]) != std::string_view::npos))
        ++end;
      if (end < small.size() && (small[end] == ':' || small[end] == '=')) first = std::min(first, end + 1);
    }
  }
  return first;
}

void strike_homes(std::string& line) {
  constexpr std::string_view kHome = "/home/";
  for (std::size_t at = line.find(kHome); at != std::string::npos; at = line.find(kHome, at + 1)) {
    const std::size_t name = at + kHome.size();
    const std::size_t end = std::min(line.find_first_of("/\"', \t:;)", name), line.size());
    line.replace(name, end - name, kStruck);
  }
}

void strike_users(std::string& line) {
  constexpr std::string_view kUser = "user ";
  for (std::size_t at = line.find(kUser); at != std::string::npos; at = line.find(kUser, at + 1)) {
    const std::size_t name = at + kUser.size();
    const std::size_t space = line.find(' ', name);
    if (space == std::string::npos || space + 2 >= line.size() || line[space + 1] != '(') continue;
    if (!is_digit(line[space + 2])) continue;
    const std::size_t end = std::min(line.find(')', space), line.size() - 1);
    line.replace(name, end + 1 - name, kStruck);
  }
}

}  // namespace

std::string without_private_words(std::string_view text) {
  std::string clean;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    std::string line(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
    if (const std::size_t secret = secret_in(line); secret != std::string::npos)
      line.replace(secret, std::string::npos, std::string(" ").append(kStruck));
    strike_homes(line);
    strike_users(line);
    clean.append(line).append("\n");
  }
  return clean;
}

}  // namespace contourd::ctl
