// print-rig: runs many random prints, or one by its seed.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <map>
#include <string>
#include <vector>

#include "tests/rig/print_rig.hpp"

namespace {

using namespace contourd;
using namespace contourd::rig;

void tell(const Figures& figures, double took_s) {
  fmt::print(
      "{} prints in {:.0f} s: {} done, {} cancelled, {} failed; {} layers in {} parts, {} slices of rises, "
      "{} interruptions; {} "
      "faults on the line, {} other happenings\n",
      figures.prints, took_s, figures.done, figures.canceled, figures.failed, figures.layers, figures.parts,
      figures.slices, figures.interruptions, figures.line_faults, figures.happenings);
  fmt::print(
      "a record's bounds are at most {:.1f} ms apart; light is at most {:.1f} ms longer than requested, "
      "within its record; the end of the light is unconfirmed for {} layers\n",
      in_ms(figures.widest), in_ms(figures.most_over), figures.unconfirmed);
  fmt::print("while the light might be on, light off or power off was sent at least every {:.1f} s\n",
             in_seconds(figures.longest_pause));
}

}  // namespace

int main(int argc, char** argv) {
  std::uint64_t first = 1, prints = 10'000, shown = 5;
  bool one = false, as_drawn = false;
  std::string rule;
  CLI::App app("Run random prints with random faults and check the records against the true light and plate");
  app.add_option("--prints", prints, "Run N worlds, each with one print or two");
  app.add_option("--seed", first, "Seed of the first world; the others count up from it");
  app.add_flag("--one", one, "Run only that world and show all its events");
  app.add_flag("--as-drawn", as_drawn, "Do not reduce scenarios that break a rule");
  app.add_option("--show", shown, "Show at most N worlds that break a rule in full");
  app.add_option("--rule", rule, "Show only worlds that break this rule, given by its letter");
  CLI11_PARSE(app, argc, argv);

  if (one) {
    fmt::print("{}", report(draw_scenario(first)));
    return print(draw_scenario(first)).violations().empty() ? 0 : 1;
  }
  const auto start = std::chrono::steady_clock::now();
  Figures figures;
  std::map<std::string, std::vector<std::uint64_t>> broken;
  for (std::uint64_t seed = first; seed < first + prints; ++seed) {
    const Scenario scenario = draw_scenario(seed);
    const Verdict verdict = print(scenario);
    figures.add(verdict.figures);
    if (verdict.violations().empty()) continue;
    for (const Violation& violation : verdict.violations())
      broken[violation.rule].push_back(seed);
    const auto is_wanted = [&rule](const Violation& v) { return v.rule.starts_with(rule); };
    if (shown == 0 || std::ranges::none_of(verdict.violations(), is_wanted)) continue;
    --shown;
    fmt::print("{}\n", report(as_drawn ? scenario : smaller(scenario, rule)));
  }
  tell(figures, std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
  for (const auto& [name, seeds] : broken)
    fmt::print(
        "BROKEN {}: {} worlds, seeds {}\n", name, seeds.size(),
        fmt::join(seeds.begin(),
                  seeds.begin() + static_cast<std::ptrdiff_t>(std::min<std::size_t>(seeds.size(), 8)), " "));
  return broken.empty() ? 0 : 1;
}
