#include "daemon/formats/model_versions.hpp"

#include <algorithm>
#include <array>
#include <cstddef>

#include "daemon/formats/model_names.hpp"

namespace contourd {
namespace {

using Words = std::vector<std::string>;

constexpr std::array<std::string_view, 7> kWith{"sup",     "supp",         "supported", "presup",
                                                "presupp", "presupported", "ps"};
constexpr std::array<std::string_view, 9> kWithout{"unsup",     "unsupp",     "unsupported",
                                                   "nosup",     "nosupp",     "nosupports",
                                                   "nosupport", "unsupports", "unsupport"};
// Words that name supports only after one of the words below, or as a folder: a part may be a support itself.
constexpr std::array<std::string_view, 2> kNouns{"support", "supports"};
constexpr std::array<std::string_view, 5> kNegations{"un", "no", "non", "not", "without"};
constexpr std::array<std::string_view, 2> kAffirmations{"pre", "with"};
constexpr std::array<std::string_view, 7> kFormatFolders{"stl", "stls", "obj", "3mf", "lys", "raw", "files"};
// Words beside those for supports in the name of a folder: "01_Lychee Supported".
constexpr std::array<std::string_view, 7> kBesideInFolders{"lychee", "chitubox", "chitu",   "prusa",
                                                           "slicer", "version",  "versions"};
// Endings of a word: "knightsupported".
constexpr std::array<std::string_view, 4> kEndings{"unsupported", "nosupports", "presupported", "supported"};

template <std::size_t Count>
bool is_one_of(const std::array<std::string_view, Count>& words, std::string_view word) {
  return std::ranges::find(words, word) != words.end();
}

bool is_digit(char c) {
  return c >= '0' && c <= '9';
}
bool is_upper(char c) {
  return c >= 'A' && c <= 'Z';
}
// Bytes of letters beyond ASCII belong to words.
bool is_lower(char c) {
  return (c >= 'a' && c <= 'z') || static_cast<unsigned char>(c) >= 0x80;
}

// Returns the words of a name in lower case: "PreSupported_v2" has "pre", "supported" and "v2".
Words words_of(std::string_view name) {
  Words words;
  bool in_word = false;
  char before = '\0';
  for (const char c : name) {
    const bool of_word = is_lower(c) || is_upper(c) || is_digit(c);
    if (of_word) {
      if (!in_word || (is_upper(c) && is_lower(before))) words.emplace_back();
      words.back() += is_upper(c) ? static_cast<char>(c - 'A' + 'a') : c;
    }
    in_word = of_word;
    before = c;
  }
  return words;
}

// Makes a word that ends with one for supports two words.
void split_endings(Words& words) {
  for (std::size_t i = 0; i < words.size(); ++i) {
    const auto* const ending = std::ranges::find_if(kEndings, [&](std::string_view each) {
      return words[i].size() > each.size() && words[i].ends_with(each);
    });
    if (ending == kEndings.end() || is_one_of(kWith, words[i]) || is_one_of(kWithout, words[i])) continue;
    const std::string begin = words[i].substr(0, words[i].size() - ending->size());
    words[i] = begin;
    words.insert(words.begin() + static_cast<std::ptrdiff_t>(++i), std::string(*ending));
  }
}

bool is_number(std::string_view word) {
  return std::ranges::all_of(word, is_digit);
}

// Takes the words for supports out of a part of a path.
NamedSupports take_supports(Words& words, bool is_folder) {
  NamedSupports found = NamedSupports::Unsaid;
  split_endings(words);
  Words rest;
  for (std::size_t i = 0; i < words.size(); ++i) {
    const bool has_next = i + 1 < words.size();
    const bool next_is_supports =
        has_next && (is_one_of(kNouns, words[i + 1]) || is_one_of(kWith, words[i + 1]));
    const bool negated = is_one_of(kNegations, words[i]) && next_is_supports;
    const bool affirmed = is_one_of(kAffirmations, words[i]) && next_is_supports;
    const bool alone_in_folder = is_folder && words.size() == 1 && is_one_of(kNouns, words[i]);
    if (negated || is_one_of(kWithout, words[i])) {
      found = NamedSupports::Without;
    } else if (affirmed || alone_in_folder || is_one_of(kWith, words[i])) {
      if (found == NamedSupports::Unsaid) found = NamedSupports::With;
    } else {
      rest.push_back(words[i]);
      continue;
    }
    if (negated || affirmed) ++i;
  }
  words = std::move(rest);
  return found;
}

}  // namespace

std::vector<std::string_view> path_parts(std::string_view path) {
  std::vector<std::string_view> parts;
  while (!path.empty()) {
    const std::string_view part = path.substr(0, path.find_first_of("/\\"));
    if (!part.empty()) parts.push_back(part);
    path.remove_prefix(std::min(part.size() + 1, path.size()));
  }
  return parts;
}

VersionName version_name(std::string_view path, std::string_view extension) {
  VersionName name;
  const std::vector<std::string_view> parts = path_parts(path.substr(0, path.size() - extension.size()));
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const bool is_folder = i + 1 < parts.size();
    Words words = words_of(parts[i]);
    const NamedSupports supports = take_supports(words, is_folder);
    // A name without supports wins: "Supported/dragon_nosup.stl".
    if (supports == NamedSupports::Without || name.supports == NamedSupports::Unsaid)
      name.supports = supports;
    if (is_folder)
      std::erase_if(words, [&](const std::string& word) {
        return is_one_of(kFormatFolders, word) ||
               (supports != NamedSupports::Unsaid && (is_number(word) || is_one_of(kBesideInFolders, word)));
      });
    for (const std::string& word : words)
      name.model += word + ' ';
    if (!words.empty()) name.model += '/';
  }
  return name;
}

bool says_supported(std::string_view path) {
  return version_name(path, model_extension(path)).supports == NamedSupports::With;
}

}  // namespace contourd
