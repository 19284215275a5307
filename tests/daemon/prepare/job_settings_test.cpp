#include "daemon/prepare/job_settings.hpp"

#include <filesystem>
#include <optional>
#include <string>

#include "tests/catch.hpp"
#include "tests/daemon/config/config_fixture.hpp"

using namespace contourd;
namespace fs = std::filesystem;

namespace {

// A printer whose profiles a test can edit, and one job.
class Desk {
 public:
  Desk() {
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
  // Whose fault it is that the profile cannot be used; nothing when it can.
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
using std::chrono::milliseconds;

constexpr const char* kTough = R"({"resin": "tough"})";
constexpr const char* kStandard = R"({"resin": "standard"})";

}  // namespace

TEST_CASE("A profile is what its file says now, with and without a ticket that names it") {
  const Desk desk;
  CHECK(desk.exposure() == milliseconds{3000});
  desk.write_resin("standard", 3500);
  desk.write_resin("tough", 4500);
  CHECK(desk.exposure() == milliseconds{3500});
  CHECK(desk.exposure(kStandard) == milliseconds{3500});
  CHECK(desk.exposure(R"({"copies": 2})") == milliseconds{3500});
  CHECK(desk.exposure(kTough) == milliseconds{4500});
}

TEST_CASE(
    "A broken profile is the profile's fault, whoever names it, and its first mistake is told with their "
    "number") {
  Desk desk;
  desk.folder.write("resins/standard.json", R"({"layer_height_um": "thin", "lift_mm": -1})");
  desk.folder.write("resins/tough.json", "{");
  CHECK(desk.fault() == Fault::Profile);
  CHECK(desk.sentence.find("the resin profile \"standard\" cannot be used: ") == 0);
  CHECK(desk.sentence.find(desk.resin("standard").string()) != std::string::npos);
  CHECK(desk.sentence.find(" more") != std::string::npos);
  CHECK(desk.fault(kStandard) == Fault::Profile);
  CHECK(desk.fault(kTough) == Fault::Profile);
  CHECK(desk.sentence.find("tough.json") != std::string::npos);
}

TEST_CASE("A profile that there is none of is the ticket's fault, but the printer's own is not") {
  Desk desk;
  CHECK(desk.fault(R"({"resin": "gold"})") == Fault::Ticket);
  fs::remove(desk.resin("standard"));
  CHECK(desk.fault() == Fault::Profile);
  CHECK(desk.fault(kStandard) == Fault::Profile);
  CHECK_FALSE(desk.fault(kTough));
}

TEST_CASE("A folder of profiles that is not there is no ticket's fault") {
  Desk desk;
  fs::remove_all(desk.folder.path() / "resins");
  CHECK(desk.fault() == Fault::Profile);
  CHECK(desk.fault(kTough) == Fault::Profile);
}

TEST_CASE("A wrong ticket is refused before its profile is looked at") {
  const Desk desk;
  desk.folder.write("resins/tough.json", "{");
  try {
    (void)desk.read(R"({"resin": "tough", "copies": 0})");
    FAIL("it was taken");
  } catch (const ProfileTrouble&) {
    FAIL("the profile was looked at");
  } catch (const JobRefused& refusal) {
    CHECK(std::string(refusal.what()).find("/copies") != std::string::npos);
  }
}

TEST_CASE("A ticket's exposure counts within the profile's limits, which are read anew each time") {
  Desk desk;
  constexpr const char* kLonger = R"({"resin": "tough", "exposure_ms": 5000})";
  const auto refusal = [&desk] {
    try {
      (void)desk.read(kLonger);
      return std::string();
    } catch (const ProfileTrouble&) {
      return std::string("it is the profile's fault");
    } catch (const JobRefused& refused) {
      return std::string(refused.what());
    }
  };
  const std::string file = (desk.folder.path() / "part.json").string(),
                    profile = (desk.folder.path() / "resins/tough.json").string();
  CHECK(refusal() == "the job ticket is wrong: " + file +
                         ": /exposure_ms: 5000 is asked for, but the resin's profile names no ticket_limits "
                         "for it: " +
                         profile);
  desk.write_resin("tough", 4000, {{"exposure_ms", {3000, 6000}}});
  CHECK(desk.exposure(kLonger) == milliseconds{5000});
  CHECK(desk.read(kLonger).overridden == OverriddenSettings{{"exposure_ms", 5000, 4000}});
  desk.write_resin("tough", 4000, {{"exposure_ms", {3000, 4500}}});
  CHECK(refusal() ==
        "the job ticket is wrong: " + file +
            ": /exposure_ms: 5000 is asked for, but the resin's profile allows tickets 3000 to 4500: " +
            profile);
}

TEST_CASE("Settings that differ in their limits alone are not the same") {
  Desk desk;
  desk.write_resin("tough", 4000, {{"exposure_ms", {3000, 6000}}});
  const JobSettings before = desk.read(kTough);
  CHECK(before == desk.read(kTough));
  desk.write_resin("tough", 4000, {{"exposure_ms", {3000, 6001}}});
  CHECK_FALSE(before == desk.read(kTough));
}
