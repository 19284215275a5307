#include <fmt/format.h>

#include "tests/allocation_counter.hpp"
#include "tests/bench/bench.hpp"

namespace contourd::bench {
namespace {

Row row_of(const Bench& bench, const std::string& model, const std::filesystem::path& file) {
  ContourEngine engine = fitted_engine(file, Pixels{1920}, Pixels{1080});
  const std::vector<Millimeters> heights = random_heights(engine.model().bounds(), bench.runs(300));
  long counted = 0;
  for (int pass = 0; pass < 2; ++pass) {  // the second pass is warm
    const long before = testing::allocations();
    for (const Millimeters z : heights)
      (void)engine.mask_at_z(z);
    counted = testing::allocations() - before;
  }
  Row row{"allocations-" + model, model + ", allocations a mask, warm", ""};
  row.figure = static_cast<double>(counted) / static_cast<double>(heights.size());
  row.target = Target{Target::Kind::AtMost, 0};
  return row;
}

}  // namespace

std::vector<Row> allocation_rows(const Bench& bench) {
  const auto plate = bench.models.shared(kPlate);
  return {plate ? row_of(bench, "plate", *plate) : skipped_rows({"allocations-plate"}, kPlate).front(),
          row_of(bench, "gyroid", bench.models.gyroid())};
}

}  // namespace contourd::bench
