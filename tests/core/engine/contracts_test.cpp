// That ContourEngine checks what it requires.
#include "core/engine/contour_engine.hpp"
#include "tests/broken_contract.hpp"
#include "tests/catch.hpp"
#include "tests/models/models.hpp"

using namespace contourd;
using testing::contract_broken_by;

namespace {

const EngineSettings kSettings{.display = {Pixels{8}, Pixels{6}, Micrometers{50.0}}};

PlateModel box() {
  return {{std::make_shared<const HeightIndex>(models::box({0, 0, 0}, {1, 1, 1}))}, {}};
}

}  // namespace

TEST_CASE("ContourEngine takes no model that is not there") {
  CHECK(contract_broken_by([] {
          ContourEngine({box(), PlateModel{}}, kSettings);
        }) == "every model is there");
}

TEST_CASE("ContourEngine knows the model, and cuts at its z, where there is one") {
  for (const std::size_t models : {std::size_t{0}, std::size_t{2}}) {
    ContourEngine engine(std::vector(models, box()), kSettings);
    CHECK(contract_broken_by([&] { (void)engine.model(); }) == "there is one model");
    CHECK(contract_broken_by([&] { (void)engine.mask_at_z(Millimeters{0.5}); }) == "there is one model");
  }
}
