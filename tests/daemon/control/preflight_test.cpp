#include "daemon/control/preflight.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "tests/catch.hpp"

namespace {

WaitingJob checked_job(std::optional<double> resin_ml = std::nullopt) {
  WaitingJob job{.file = "gear.stl", .arrived = {}};
  job.check = WaitingJob::Check::Passed;
  job.outlook = JobOutlook{.layers = 200, .height_mm = 10};
  if (resin_ml) {
    job.analyzed.emplace();
    job.analyzed->analysis.resin_ml = resin_ml;
  }
  return job;
}

Verdict verdict_of(std::string_view check, const WaitingJob& job, const PreflightFacts& facts) {
  const std::vector<PreflightCheck> checks = preflight(job, facts);
  const auto found = std::ranges::find(checks, check, &PreflightCheck::name);
  REQUIRE(found != checks.end());
  CHECK_FALSE(found->text.empty());
  return found->verdict;
}

PreflightFacts sound() {
  PreflightFacts facts;
  facts.display = "1920 x 1080 pixels at 60 Hz";
  facts.vat_ml = 50;
  return facts;
}

}  // namespace

TEST_CASE("A sound printer and job pass every check") {
  const auto reply = preflight_json("gear.stl", preflight(checked_job(20), sound()));
  CHECK(reply["verdict"] == "pass");
  for (const auto& check : reply["checks"])
    CHECK(check["verdict"] == "pass");
}

TEST_CASE(
    "A job that needs more resin than the vat holds is warned about, and so is a vat that is not known") {
  CHECK(verdict_of("resin", checked_job(20), sound()) == Verdict::Pass);
  CHECK(verdict_of("resin", checked_job(51), sound()) == Verdict::Warn);
  CHECK(verdict_of("resin", checked_job(), sound()) == Verdict::Warn);
  PreflightFacts unknown = sound();
  unknown.vat_ml.reset();
  CHECK(verdict_of("resin", checked_job(20), unknown) == Verdict::Warn);
}

TEST_CASE("What keeps a job waiting refuses, and the reply has the worst verdict") {
  PreflightFacts facts = sound();
  facts.not_ready = "the lid is open";
  CHECK(verdict_of("machine", checked_job(20), facts) == Verdict::Refuse);
  CHECK(preflight_json("gear.stl", preflight(checked_job(20), facts))["verdict"] == "refuse");
  facts = sound();
  facts.disk_trouble = "the spool's disk has 1 MB free, 100 MB are needed";
  CHECK(verdict_of("disk", checked_job(20), facts) == Verdict::Refuse);
  facts = sound();
  facts.queue_waits = "the plate is occupied";
  CHECK(verdict_of("queue", checked_job(20), facts) == Verdict::Refuse);
  WaitingJob asks = checked_job(20);
  asks.asks = {"islands"};
  CHECK(verdict_of("findings", asks, sound()) == Verdict::Refuse);
}

TEST_CASE(
    "Preflight warns of worn parts, findings and a sensor that cannot be read, and reports the temperature") {
  PreflightFacts facts = sound();
  facts.due = {"the film is due"};
  CHECK(verdict_of("wear", checked_job(20), facts) == Verdict::Warn);
  facts.resin_c = 24.25;
  CHECK(verdict_of("temperature", checked_job(20), facts) == Verdict::Pass);
  facts.resin_trouble = "the sensor cannot be read";
  CHECK(verdict_of("temperature", checked_job(20), facts) == Verdict::Warn);
  WaitingJob job = checked_job(20);
  job.analyzed->analysis.warnings.assign(30, "an island");
  const std::vector<PreflightCheck> checks = preflight(job, facts);
  CHECK(std::ranges::count(checks, std::string_view("findings"), &PreflightCheck::name) == 21);
  CHECK(checks.back().text == "and 10 more");
}
