#include "tests/rig/print_rig.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "tests/rig/world.hpp"

namespace contourd::rig {

Verdict print(const Scenario& scenario) {
  World world(scenario);
  world.run();
  return world.verdict();
}

Scenario smaller(Scenario scenario, const std::string& rule_begin) {
  const Verdict shown = print(scenario);
  const auto begins_so = [&rule_begin](const Violation& v) { return v.rule.starts_with(rule_begin); };
  const std::string rule = std::ranges::find_if(shown.violations(), begins_so)->rule;
  const auto still_shows = [&rule](const Scenario& candidate) {
    const Verdict verdict = print(candidate);
    return std::ranges::any_of(verdict.violations(), [&rule](const Violation& v) { return v.rule == rule; });
  };
  const auto try_to = [&](const auto& change) {
    Scenario candidate = scenario;
    change(candidate);
    if (still_shows(candidate)) scenario = candidate;
  };
  for (std::size_t i = scenario.happenings.size(); i-- > 0;)
    try_to([i](Scenario& s) { s.happenings.erase(s.happenings.begin() + static_cast<std::ptrdiff_t>(i)); });
  for (double LineFaults::*rate :
       {&LineFaults::command_lost, &LineFaults::command_garbled, &LineFaults::reply_lost,
        &LineFaults::reply_garbled, &LineFaults::reply_late, &LineFaults::reply_doubled})
    try_to([rate](Scenario& s) { s.line.*rate = 0; });
  try_to([](Scenario& s) { s.prints = 1; });
  try_to([](Scenario& s) { s.layers = 1; });
  try_to([](Scenario& s) { s.encoder = EncoderKind::None; });
  try_to([](Scenario& s) { s.backlash = false; });
  return scenario;
}

std::string report(const Scenario& scenario) {
  World world(scenario);
  world.keep_story();
  world.run();
  std::string text = describe(scenario);
  for (const std::string& line : world.story())
    text += line + "\n";
  for (const Violation& violation : world.verdict().violations()) {
    text += fmt::format("{:9.4f} s  BROKEN {}: {}\n",
                        std::chrono::duration<double>(violation.at.time_since_epoch()).count(),
                        violation.rule, violation.what);
  }
  return text;
}

}  // namespace contourd::rig
