// An encoder for tests, and the words of its findings.
#pragma once

#include <optional>
#include <string>

#include "hw/gpio/gpio_axis_config.hpp"
#include "tests/catch.hpp"

namespace contourd::testing {

// Returns an encoder on the lines 7 and 8, whose index on line 9 comes every 4 mm.
inline EncoderConfig encoder_config(double counts_per_mm) {
  EncoderConfig config;
  config.a.line = "7";
  config.b.line = "8";
  config.counts_per_mm = counts_per_mm;
  config.index = GpioLineConfig{"gpiochip0", "9", false};
  config.index_every = Nanometers{4'000'000};
  return config;
}

inline bool says(const std::optional<std::string>& sentence, const std::string& words) {
  UNSCOPED_INFO(sentence.value_or("nothing"));
  return sentence && sentence->find(words) != std::string::npos;
}

}  // namespace contourd::testing
