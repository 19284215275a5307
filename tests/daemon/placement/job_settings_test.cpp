#include "daemon/placement/job_settings.hpp"

#include <filesystem>

#include "tests/catch.hpp"
#include "tests/daemon/config/config_fixture.hpp"

namespace fs = std::filesystem;

namespace {

// A printer with profiles that a test can edit, and a job.
class JobSettingsFixture {
 public:
  JobSettingsFixture() {
    write_resin("standard", 3000);
    write_resin("tough", 4000);
    fs::create_directory(folder.path() / "spool");
    nlohmann::json file = testing::shipped("simulated.json");
    file["resins_folder"] = "resins";
    printer = load_printer_config(folder.write_json("contourd.json", file));
  }
  void write_resin(const std::string& name, double exposure_ms,
                   const nlohmann::json& limits = nullptr) const {
    nlohmann::json profile = testing::shipped("resins/standard.json");
    profile["exposure_ms"] = exposure_ms;
    if (!limits.is_null()) profile["ticket_limits"] = limits;
    folder.write_json("resins/" + name + ".json", profile);
  }
  [[nodiscard]] JobSettings read(const std::string& ticket = "") const {
    JobFiles files{"part", folder.path() / "part.stl", std::nullopt};
    if (!ticket.empty()) files.ticket = folder.write("part.json", ticket);
    return read_settings(files, printer);
  }
  [[nodiscard]] Duration exposure(const std::string& ticket = "") const {
    return std::get<FixedExposure>(read(ticket).resin.exposure).exposure;
  }
  // Returns who is at fault if the profile cannot be used; nullopt if it can be used.
  [[nodiscard]] std::optional<ProfileTrouble::Fault> fault(const std::string& ticket = "") {
    try {
      (void)read(ticket);
      return std::nullopt;
    } catch (const ProfileTrouble& trouble) {
      CHECK(trouble.sentence().find('\n') == std::string::npos);
      sentence = trouble.sentence();
      return trouble.fault();
    }
  }
  [[nodiscard]] fs::path resin(const std::string& name) const {
    return folder.path() / "resins" / (name + ".json");
  }

  testing::ConfigFolder folder;
  PrinterConfig printer;
  std::string sentence;
};

using Fault = ProfileTrouble::Fault;

constexpr const char* kTough = R"({"resin": "tough"})";
constexpr const char* kStandard = R"({"resin": "standard"})";

}  // namespace

TEST_CASE("A profile's current file counts, with and without a ticket that names it") {
  const JobSettingsFixture fixture;
  CHECK(fixture.exposure() == std::chrono::milliseconds{3000});
  fixture.write_resin("standard", 3500);
  fixture.write_resin("tough", 4500);
  CHECK(fixture.exposure() == std::chrono::milliseconds{3500});
  CHECK(fixture.exposure(kStandard) == std::chrono::milliseconds{3500});
  CHECK(fixture.exposure(R"({"copies": 2})") == std::chrono::milliseconds{3500});
  CHECK(fixture.exposure(kTough) == std::chrono::milliseconds{4500});
}

TEST_CASE(
    "A broken profile is the profile's fault, whoever names it, and the first mistake and the number of "
    "others "
    "are reported") {
  JobSettingsFixture fixture;
  fixture.folder.write("resins/standard.json", R"({"layer_height_um": "thin", "lift_mm": -1})");
  fixture.folder.write("resins/tough.json", "{");
  CHECK(fixture.fault() == Fault::Profile);
  CHECK(fixture.sentence.find("the resin profile \"standard\" cannot be used: ") == 0);
  CHECK(fixture.sentence.find(fixture.resin("standard").string()) != std::string::npos);
  CHECK(fixture.sentence.find(" more") != std::string::npos);
  CHECK(fixture.fault(kStandard) == Fault::Profile);
  CHECK(fixture.fault(kTough) == Fault::Profile);
  CHECK(fixture.sentence.find("tough.json") != std::string::npos);
}

TEST_CASE("A missing profile is the ticket's fault if the ticket names it, unless it is the printer's own") {
  JobSettingsFixture fixture;
  CHECK(fixture.fault(R"({"resin": "gold"})") == Fault::Ticket);
  fs::remove(fixture.resin("standard"));
  CHECK(fixture.fault() == Fault::Profile);
  CHECK(fixture.fault(kStandard) == Fault::Profile);
  CHECK_FALSE(fixture.fault(kTough));
}

TEST_CASE("A missing folder of profiles is not the ticket's fault") {
  JobSettingsFixture fixture;
  fs::remove_all(fixture.folder.path() / "resins");
  CHECK(fixture.fault() == Fault::Profile);
  CHECK(fixture.fault(kTough) == Fault::Profile);
}

TEST_CASE("A wrong ticket is refused before its profile is read") {
  const JobSettingsFixture fixture;
  fixture.folder.write("resins/tough.json", "{");
  try {
    (void)fixture.read(R"({"resin": "tough", "copies": 0})");
    FAIL("the ticket was accepted");
  } catch (const ProfileTrouble&) {
    FAIL("the profile was read");
  } catch (const JobRefused& refusal) {
    CHECK(std::string(refusal.what()).find("/copies") != std::string::npos);
  }
}

TEST_CASE("A ticket's exposure counts within the profile's limits, which are read again each time") {
  JobSettingsFixture fixture;
  constexpr const char* kLonger = R"({"resin": "tough", "exposure_ms": 5000})";
  const auto refusal = [&fixture] {
    try {
      (void)fixture.read(kLonger);
      return std::string();
    } catch (const ProfileTrouble&) {
      return std::string("it is the profile's fault");
    } catch (const JobRefused& refused) {
      return std::string(refused.what());
    }
  };
  const std::string file = (fixture.folder.path() / "part.json").string(),
                    profile = (fixture.folder.path() / "resins/tough.json").string();
  CHECK(refusal() == "the job ticket is wrong: " + file +
                         ": /exposure_ms: 5000 is asked for, but the resin's profile names no ticket_limits "
                         "for it: " +
                         profile);
  fixture.write_resin("tough", 4000, {{"exposure_ms", {3000, 6000}}});
  CHECK(fixture.exposure(kLonger) == std::chrono::milliseconds{5000});
  CHECK(fixture.read(kLonger).overridden == OverriddenSettings{{"exposure_ms", 5000, 4000}});
  fixture.write_resin("tough", 4000, {{"exposure_ms", {3000, 4500}}});
  CHECK(refusal() ==
        "the job ticket is wrong: " + file +
            ": /exposure_ms: 5000 is asked for, but the resin's profile allows tickets 3000 to 4500: " +
            profile);
}

TEST_CASE("Settings that differ only in their limits are not equal") {
  JobSettingsFixture fixture;
  fixture.write_resin("tough", 4000, {{"exposure_ms", {3000, 6000}}});
  const JobSettings before = fixture.read(kTough);
  CHECK(before == fixture.read(kTough));
  fixture.write_resin("tough", 4000, {{"exposure_ms", {3000, 6001}}});
  CHECK_FALSE(before == fixture.read(kTough));
}
