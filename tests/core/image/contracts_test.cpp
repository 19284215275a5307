// Checks that the headers of core/image enforce their requirements.

#include "core/image/run_deflater.hpp"
#include "core/image/thumbnail.hpp"
#include "tests/broken_contract.hpp"
#include "tests/catch.hpp"

TEST_CASE("A stream of runs is at most as long as that of the largest mask") {
  if (testing::costly_checks_are_off()) return;
  const auto stream_of = [](std::size_t bytes) {
    return contract_broken_by([bytes] {
      std::vector<std::uint8_t> out;
      RunDeflater deflater;
      deflater.begin(out, 0);
      deflater.add(255, 1);
      deflater.add(255, bytes - 1);
    });
  };
  CHECK(stream_of(RunDeflater::kMaxBytes).empty());
  CHECK(stream_of(RunDeflater::kMaxBytes + 1) == "a stream has at most kMaxBytes");
}

TEST_CASE("A thumbnail needs a box within the mask") {
  const Mask mask(Pixels{10}, Pixels{5});
  const auto broken = [&](const PixelBox& box, std::int32_t longest) {
    return contract_broken_by([&] { (void)make_thumbnail(mask, box, Pixels{longest}); });
  };
  const std::string outside = "the box has pixels and lies in the mask";
  CHECK(broken({0, 0, 11, 5}, 5) == outside);
  CHECK(broken({0, 0, 10, 6}, 5) == outside);
  CHECK(broken({-1, 0, 10, 5}, 5) == outside);
  CHECK(broken({3, 0, 3, 5}, 5) == outside);
  CHECK(broken({0, 0, 10, 5}, 0) == "a thumbnail has pixels");
  CHECK(broken({0, 0, 10, 5}, 1).empty());
}
