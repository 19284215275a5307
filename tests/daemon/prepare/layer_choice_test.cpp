#include "daemon/prepare/layer_choice.hpp"

#include "tests/catch.hpp"
#include "tests/daemon/prepare/print_job_fixture.hpp"

using namespace contourd;
using testing::kCube;
using testing::PrintJobFixture;

TEST_CASE_METHOD(PrintJobFixture, "More layers than can be printed are refused with their number") {
  // More travel than any machine has, so that only the number of layers is wrong.
  printer.travel = Nanometers{20'000'000'000'000};
  resin.layer_height = resin.layer_height_min = Nanometers{1'000};
  CHECK(refusal_of(models::box({0, 0, 0}, {5, 5, 16'384})) ==
        "the model has 16384000 layers, at most 10000000 can be printed");
}

TEST_CASE_METHOD(PrintJobFixture, "A layer height that the resin does not allow is refused") {
  CHECK(refusal_of(kCube, R"({"layer_height_um": 5})").find("the layer height cannot be printed") == 0);
}

TEST_CASE_METHOD(PrintJobFixture,
                 "Adaptive layers are thin on slopes and thick on walls, within what the resin prints") {
  resin.exposure = CurveExposure{Micrometers{60}, Micrometers{200}};
  resin.cure = CureSettings{.curve = {Micrometers{150}, MillijoulesPerCm2{9}}};
  const PreparedJob job = prepare(models::cone(8, 8, 96), R"({"adaptive_layers": {"cusp_um": 40}})");
  CHECK(job.summary.layers.adaptive);
  // 40 um on a slope of nearly 45 degrees: its facets are a little less steep than the round cone.
  CHECK(job.summary.layers.thickest == Nanometers{56'000});
  CHECK(job.summary.layers.count == 143);
  CHECK(job.plan.exposure(20, Nanometers{50'000}) < job.plan.exposure(20, Nanometers{100'000}));
  CHECK(prepare(kCube, R"({"adaptive_layers": {"cusp_um": 40}})").summary.layers.count == 200);
  CHECK(refusal_of(kCube, R"({"adaptive_layers": {"cusp_um": 40, "min_um": 10}})")
            .find("the layer height cannot be printed") == 0);
}

TEST_CASE_METHOD(PrintJobFixture, "Adaptive layers without a working curve are refused") {
  CHECK(refusal_of(kCube, R"({"adaptive_layers": {"cusp_um": 10}})") ==
        "adaptive layers need a resin with a working curve: the exposure times of \"standard\" are "
        "valid only for its layer height of 50 um");
}
