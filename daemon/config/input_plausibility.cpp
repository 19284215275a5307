#include "daemon/config/input_plausibility.hpp"

#include <array>
#include <string>

namespace contourd {
namespace {

struct Input {
  const char* pointer;
  const char* consequence;  // the effect of a broken wire that goes unnoticed
};

constexpr std::array kInputs{
    Input{"/z_axis/limit_switch", "homing drives the plate on against its end"},
    Input{"/z_axis/second_switch", "a move runs on against the end"},
    Input{"/z_axis/emergency_stop", "pressing it stops nothing"},
    Input{"/z_axis/lid", "the light stays on under an open lid"},
};

// Returns why a broken wire would go unnoticed, as the start of a sentence that the consequence completes;
// empty if it would be noticed.
std::string warning(const std::string& contact, const std::string& bias, bool active_low) {
  if (contact == "normally_open")
    return "the contact is normally open, so a broken wire goes unnoticed: then ";
  const std::string good = active_low ? "pull_up" : "pull_down", bad = active_low ? "pull_down" : "pull_up";
  if (bias == good) return {};
  if (bias == bad) {
    return "the bias " + in_quotes(bias) +
           " pulls the line to its level at rest, so a broken wire goes unnoticed: then ";
  }
  return "the bias " + in_quotes(bias) +
         " leaves a broken wire's level to chance where no resistor is fitted (" + in_quotes(good) +
         " would make it noticed): at worst ";
}

}  // namespace

void warn_of_implausible_contacts(JsonDocument& printer) {
  if (printer.valid_text("/hardware") != "real") return;
  for (const Input& input : kInputs) {
    const std::string place = input.pointer;
    const auto contact = printer.valid_text(place + "/contact"), bias = printer.valid_text(place + "/bias");
    const auto active_low = printer.valid_boolean(place + "/active_low");
    if (!contact || !bias || !active_low) continue;
    const std::string what = warning(*contact, *bias, *active_low);
    if (!what.empty()) printer.add_warning(place, what + input.consequence);
  }
}

}  // namespace contourd
