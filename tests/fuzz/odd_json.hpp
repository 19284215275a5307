// Texts of JSON for the fuzzers that are odd but possible. Values; thread-safe.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace contourd::fuzz {

inline std::string quoted(std::size_t letters) {
  return '"' + std::string(letters, 'a') + '"';
}

inline std::string nested(std::size_t arrays) {
  return std::string(arrays, '[') + std::string(arrays, ']');
}

// Values at and beyond the limits of JSON and of its reader.
inline std::vector<std::string> odd_values() {
  return {"1e999",
          "-1e999",
          "1e308",
          "5e-324",
          "-0",
          "-0.0",
          "1e18",
          "9007199254740993",
          "18446744073709551615",
          "18446744073709551616",
          R"("")",
          R"("\ud800")",
          R"("\ufeff\u202e\uffff")",
          quoted(1024),
          quoted(1025),
          nested(62),
          nested(65),
          "null",
          "true",
          R"({"x": 1, "x": 2})"};
}

// The place of a number or a text in a text of JSON.
struct Place {
  std::size_t begin, end;
};

inline std::vector<Place> places_in(const std::string& json, bool of_texts) {
  std::vector<Place> places;
  for (std::size_t at = json.find("\": "); at != std::string::npos; at = json.find("\": ", at + 1)) {
    const std::size_t begin = at + 3;
    const bool is_text = json[begin] == '"';
    if (is_text == of_texts && json[begin] != '{' && json[begin] != '[')
      places.push_back({begin, is_text ? json.find('"', begin + 1) + 1 : json.find_first_of(",}\n", begin)});
  }
  return places;
}

// Returns a sound text of JSON after odd marks, with a NUL in place of each of its texts, and with each odd
// value in place of one of its own.
inline std::vector<std::string> odd_variants(const std::string& sound) {
  const std::string mark = "\xEF\xBB\xBF";
  std::vector<std::string> variants{mark + sound, mark + mark + sound, "\xFF\xFE" + sound,
                                    std::string(1, '\0') + sound};
  const auto add = [&](const Place& place, const std::string& value) {
    variants.push_back(sound.substr(0, place.begin) + value + sound.substr(place.end));
  };
  const std::vector<Place> texts = places_in(sound, true), numbers = places_in(sound, false);
  for (const Place& text : texts)
    add(text, R"("\u0000")");
  for (const std::string& odd : odd_values()) {
    const std::vector<Place>& places = odd.front() == '"' ? texts : numbers;
    add(places[variants.size() % places.size()], odd);
  }
  return variants;
}

}  // namespace contourd::fuzz
