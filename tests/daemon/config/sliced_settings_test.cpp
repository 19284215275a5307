#include "daemon/config/sliced_settings.hpp"

#include "tests/catch.hpp"
#include "tests/daemon/config/resin_fixture.hpp"

namespace {

struct Settled {
  JobTicket ticket{};
  ResinProfile resin = limited();
  OverriddenSettings overridden{};
  std::string refusal{};

  static ResinProfile limited() {
    nlohmann::json profile = testing::shipped("resins/standard.json");
    profile["growth_um"] = 20;
    profile["ticket_limits"] = {{"exposure_ms", {1000, 8000}}, {"bottom_exposure_ms", {4000, 60000}}};
    return testing::load_resin(profile);
  }

  Settled& with(const FileLayers& layers) {
    refusal = settle_for_layers(layers, testing::kIrradianceMwCm2, ticket, resin, overridden);
    return *this;
  }
};

const FileLayers kLayers{Nanometers{100'000},
                         FileExposures{std::chrono::seconds(2), std::chrono::seconds(10), 3, 4}};

}  // namespace

TEST_CASE("Pictures take their layer height and no correction for the resin, which exposes them") {
  Settled settled;
  settled.resin.undersides = Undersides::Dose;
  settled.resin.mode = PrintWay::Continuous;
  settled.resin.shrinkage_factors = Scale{1.01};
  CHECK(settled.with(kLayers).refusal.empty());
  CHECK(settled.ticket.layer_height == Nanometers{100'000});
  CHECK(settled.resin.compensation == Compensation{});
  CHECK(settled.resin.shrinkage_factors == Scale{});
  CHECK(settled.resin.undersides == Undersides::Plain);
  CHECK(settled.resin.mode == PrintWay::Layered);
  CHECK(settled.resin.exposure == Settled::limited().exposure);
  CHECK(settled.overridden.empty());
}

TEST_CASE("Outlines keep the resin's compensation, and lose its shrinkage as pictures do") {
  Settled settled;
  const Compensation compensation = settled.resin.compensation;
  REQUIRE(compensation != Compensation{});
  FileLayers outlines = kLayers;
  outlines.outlines = true;
  CHECK(settled.with(outlines).refusal.empty());
  CHECK(settled.resin.compensation == compensation);
  CHECK(settled.resin.shrinkage_factors == Scale{});
}

TEST_CASE("A ticket takes the exposures from the file, within the profile's limits") {
  Settled settled;
  settled.ticket.exposures_of_file = true;
  CHECK(settled.with(kLayers).refusal.empty());
  CHECK(settled.overridden ==
        OverriddenSettings{{"exposure_ms", 2000, 3000}, {"bottom_exposure_ms", 10'000, 30'000}});
  const auto exposure = [&](int layer) {
    return exposure_time(settled.resin, kLayers.thickness, layer, testing::kIrradianceMwCm2);
  };
  CHECK(exposure(0) == std::chrono::seconds(10));
  CHECK(exposure(2) == std::chrono::seconds(10));
  CHECK(exposure(3) == std::chrono::milliseconds(8400));
  CHECK(exposure(7) == std::chrono::seconds(2));
  FileLayers dim = kLayers;
  dim.exposures->normal = std::chrono::milliseconds(500);
  CHECK(testing::lacking(settled.with(dim).refusal, {"exposure_ms is 500", "1000 to 8000"}).empty());
  CHECK(testing::lacking(settled.with({kLayers.thickness}).refusal, {"names none"}).empty());
  settled.resin.limits = {};
  CHECK(testing::lacking(settled.with(kLayers).refusal, {"no ticket_limits for exposure_ms"}).empty());
}

TEST_CASE("A ticket's wishes that need a model are refused, each by its key") {
  const auto refusal = [](const std::function<void(JobTicket&)>& ask) {
    Settled settled;
    ask(settled.ticket);
    return settled.with(kLayers).refusal;
  };
  const std::map<std::string, std::function<void(JobTicket&)>> wishes{
      {"adaptive_layers", [](JobTicket& ticket) { ticket.adaptive.emplace(); }},
      {"undersides", [](JobTicket& ticket) { ticket.undersides = Undersides::Dose; }},
      {"mode", [](JobTicket& ticket) { ticket.mode = PrintWay::Continuous; }},
      {"cracks", [](JobTicket& ticket) { ticket.cracks = CrackPolicy::Refuse; }},
      {"supports", [](JobTicket& ticket) { ticket.supports = SupportTicket{SupportPolicy::On}; }},
      {"unit", [](JobTicket& ticket) { ticket.models.front().unit = LengthUnit::Inch; }},
      {"rotation_deg", [](JobTicket& ticket) { ticket.models.front().rotation.x = 90; }},
      {"up",
       [](JobTicket& ticket) {
         ticket.models.front().up = Direction{0, 1, 0};
       }},
      {"scale", [](JobTicket& ticket) { ticket.models.front().scale = Scale{2}; }},
      {"fit", [](JobTicket& ticket) { ticket.models.front().fit = true; }},
      {"position_mm", [](JobTicket& ticket) { ticket.models.front().position.emplace(); }},
      {"copies", [](JobTicket& ticket) { ticket.models.front().copies = 2; }},
      {"drain", [](JobTicket& ticket) { ticket.models.front().drain.emplace_back(); }},
      {"hollow", [](JobTicket& ticket) { ticket.models.front().hollow.emplace(); }},
  };
  for (const auto& [key, ask] : wishes)
    CHECK(testing::lacking(refusal(ask), {"asks for " + key + ", which needs a model"}).empty());
  CHECK(refusal([](JobTicket& ticket) {
          ticket.undersides = Undersides::Plain;
          ticket.mode = PrintWay::Layered;
          ticket.supports = SupportTicket{SupportPolicy::Auto};
          ticket.layer_height = Nanometers{100'000};
        }).empty());
}

TEST_CASE("Another layer height than the file's is refused, and so are exposures for another one") {
  Settled settled;
  settled.ticket.layer_height = Nanometers{50'000};
  CHECK(testing::lacking(settled.with(kLayers).refusal, {"layers of 50 um", "100 um thick"}).empty());
  Settled exposed;
  exposed.ticket.overrides.exposure = std::chrono::seconds(4);
  CHECK(testing::lacking(exposed.with(kLayers).refusal, {"\"layer_height_um\": 100"}).empty());
  exposed.ticket.layer_height = Nanometers{100'000};
  CHECK(exposed.with(kLayers).refusal.empty());
}
