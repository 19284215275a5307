#include "daemon/prepare/preprint_analysis.hpp"

#include "tests/catch.hpp"

using Names = std::vector<std::string>;

namespace {

PrinterConfig printer_that_asks(const Names& names) {
  PrinterConfig printer;
  printer.ask_before = names;
  printer.tiny_first_layer_percent = 5;
  return printer;
}

// A job of two layers of 10 mm2 and a watertight model.
struct Job {
  Job() {
    findings.area_mm2 = {10, 10};
    findings.largest_area_mm2 = 10;
    findings.volume_mm3 = 1000;
    summary.models.emplace_back().mesh.watertight = true;
  }
  [[nodiscard]] PreprintAnalysis analysis() const {
    return preprint_analysis_of(summary, findings, printer_that_asks({}));
  }
  PrintFindings findings;
  JobSummary summary;
};

bool warns(const PreprintAnalysis& analysis, const std::string& text) {
  return std::ranges::any_of(
      analysis.warnings, [&](const std::string& warning) { return warning.find(text) != std::string::npos; });
}

}  // namespace

TEST_CASE("A sound job has no finding") {
  const PreprintAnalysis analysis = Job().analysis();
  CHECK(analysis.findings.empty());
  CHECK(analysis.warnings.empty());
  CHECK(analysis.resin_ml == testing::Approx(1));
}

TEST_CASE("Unheld places need confirmation whatever ask_before names") {
  Job job;
  job.summary.supports.emplace().unheld = {{{{1, 2, 3}, {0, 0, -1}, ContactCause::Island, 0.5}, "no way"}};
  const PreprintAnalysis analysis = job.analysis();
  CHECK(analysis.findings == Names{"unheld_places"});
  CHECK(asked_findings(analysis, printer_that_asks({})) == Names{"unheld_places"});
  const auto without_masks = analysis_of_preparation(job.summary);
  REQUIRE(without_masks);
  CHECK(without_masks->findings == Names{"unheld_places"});
  CHECK_FALSE(without_masks->resin_ml);
  job.summary.supports->unheld.clear();
  CHECK(job.analysis().findings.empty());
  CHECK_FALSE(analysis_of_preparation(job.summary));
}

TEST_CASE("Wide gaps need confirmation whatever ask_before names") {
  Job job;
  job.summary.wide_gaps = "much is missing";
  CHECK(asked_findings(job.analysis(), printer_that_asks({})) == Names{"wide_gaps"});
  REQUIRE(analysis_of_preparation(job.summary));
  CHECK(analysis_of_preparation(job.summary)->findings == Names{"wide_gaps"});
}

TEST_CASE("A job that its ticket has wait needs confirmation whatever ask_before names") {
  Job job;
  job.summary.confirm = true;
  CHECK(asked_findings(job.analysis(), printer_that_asks({"islands"})) == Names{"to_be_confirmed"});
  REQUIRE(analysis_of_preparation(job.summary));
  CHECK(analysis_of_preparation(job.summary)->findings == Names{"to_be_confirmed"});
}

TEST_CASE("Each finding has a name and a warning") {
  Job job;
  SECTION("islands") {
    job.findings.island_count = 1;
    job.findings.islands = {{1, {1, 2}, {0, 0}, 2}};
    CHECK(job.analysis().findings == Names{"islands"});
    CHECK(warns(job.analysis(), "island"));
  }
  SECTION("suction cups") {
    job.findings.suction_cup_count = 1;
    job.findings.suction_cups = {{0, 9, 4, {1, 2}, {0, 0}, 81, 800, false}};
    CHECK(job.analysis().findings == Names{"suction_cups"});
    CHECK(warns(job.analysis(), "suction cup"));
  }
  SECTION("resin traps") {
    job.findings.resin_trap_count = 1;
    job.findings.resin_traps = {{0, 9, 4, {1, 2}, {0, 0}, 81, 800, false}};
    CHECK(job.analysis().findings == Names{"resin_traps"});
    CHECK(warns(job.analysis(), "closed hollow"));
  }
  SECTION("a tiny first layer") {
    job.findings.area_mm2[0] = 0.49;
    CHECK(job.analysis().findings == Names{"tiny_first_layer"});
    CHECK(warns(job.analysis(), "layer 1 is tiny: it covers 0.49 mm², 4.9 % of layer 1"));
    job.findings.area_mm2[0] = 0.5;
    CHECK(job.analysis().findings.empty());
  }
  SECTION("contours that do not close") {
    job.findings.cracks.open_chains = 1;
    CHECK(job.analysis().findings == Names{"cracks"});
  }
  SECTION("contours that were turned") {
    job.findings.cracks.turned_chains = 1;
    CHECK(job.analysis().findings == Names{"cracks"});
  }
  SECTION("facets that were turned") {
    job.summary.models[0].repairs.turned = 1;
    CHECK(job.analysis().findings == Names{"cracks"});
  }
  SECTION("a mesh with open edges") {
    job.summary.models[0].mesh.watertight = false;
    CHECK(job.analysis().findings == Names{"not_watertight"});
  }
  SECTION("shells that are wound against their place") {
    job.summary.models[0].shells.inside_out = 1;
    CHECK(job.analysis().findings == Names{"inverted_shells"});
    job.summary.models[0].shells = {.filled = 1};
    CHECK(job.analysis().findings == Names{"inverted_shells"});
    job.summary.models[0].shells = {.within = 1};
    CHECK(job.analysis().findings == Names{"inverted_shells"});
  }
  SECTION("layers without light") {
    job.findings.empty_layers = {0};
    CHECK(job.analysis().findings == Names{"empty_layers"});
  }
  SECTION("masks that take too long") {
    job.findings.abandoned_layers = {1};
    CHECK(job.analysis().findings == Names{"abandoned_layers"});
  }
}

TEST_CASE("Duplicate facets are not a crack") {
  Job job;
  job.summary.models[0].repairs.doubled = 3;
  CHECK(job.analysis().findings.empty());
}

TEST_CASE("Findings named in ask_before need confirmation, and so does a job that could not be analyzed") {
  PreprintAnalysis analysis;
  analysis.findings = {"islands", "cracks"};
  CHECK(asked_findings(analysis, printer_that_asks({})).empty());
  CHECK(asked_findings(analysis, printer_that_asks({"cracks", "empty_layers"})) == Names{"cracks"});
  analysis.findings = {std::string(kNotAnalyzed)};
  CHECK(asked_findings(analysis, printer_that_asks({"cracks"})) == analysis.findings);
}

TEST_CASE("Warnings are limited in number and length") {
  Job job;
  job.summary.warnings.assign(1000, std::string(10'000, 'x'));
  const PreprintAnalysis analysis = job.analysis();
  REQUIRE(analysis.warnings.size() == 20);
  CHECK(analysis.warnings.back() == "and 981 more warnings");
  CHECK(analysis.warnings.front().size() < 600);
}

TEST_CASE("Findings are printed in words") {
  CHECK(findings_text({}).empty());
  CHECK(findings_text({"islands", "tiny_first_layer"}) == "islands, tiny first layer");
}
