// Checks that ContourEngine checks what it requires.
#include "core/engine/contour_engine.hpp"
#include "tests/broken_contract.hpp"
#include "tests/catch.hpp"
#include "tests/models/models.hpp"

namespace {

const EngineSettings kEngineSettings{.display = {Pixels{8}, Pixels{6}, Micrometers{50.0}}};

PlateModel unit_box_model() {
  return {{std::make_shared<const HeightIndex>(models::box({0, 0, 0}, {1, 1, 1}))}, {}};
}

}  // namespace

TEST_CASE("ContourEngine requires models that are not null") {
  CHECK(contract_broken_by([] {
          ContourEngine({unit_box_model(), PlateModel{}}, kEngineSettings);
        }) == "no model is null");
}

TEST_CASE("ContourEngine darkens copies that it has, and replaces sections upwards") {
  ContourEngine engine({unit_box_model()}, kEngineSettings);
  const std::string no_copy = "there is such a copy", no_order = "sections replace those beneath them";
  CHECK(contract_broken_by([&] { engine.darken(0, 0, Nanometers{}); }) == no_copy);
  CHECK(contract_broken_by([&] { engine.darken(1, 0, Nanometers{}); }) == no_copy);
  CHECK(contract_broken_by([&] { engine.replace_beside(nullptr, Nanometers{}); }) == no_order);
}

TEST_CASE("ContourEngine returns the model, and cuts at its z, if there is only one") {
  for (const std::size_t models : {std::size_t{0}, std::size_t{2}}) {
    ContourEngine engine(std::vector(models, unit_box_model()), kEngineSettings);
    CHECK(contract_broken_by([&] { (void)engine.model(); }) == "there is one model");
    CHECK(contract_broken_by([&] { (void)engine.mask_at_z(Millimeters{0.5}); }) == "there is one model");
  }
}
