#include "daemon/prepare/job_memory.hpp"

#include "tests/catch.hpp"
#include "tests/models/models.hpp"

namespace {

constexpr DisplayGeometry kDisplay{Pixels{1920}, Pixels{1080}, Micrometers{50}};

FileToRead binary(std::uint64_t facets, std::size_t models = 1) {
  return {{.most_facets = facets, .exact = true}, models};
}

std::uint64_t memory_of(const std::vector<FileToRead>& files) {
  return memory_to_prepare(files, kDisplay) - memory_for_display(kDisplay);
}

PlateModel plate_model(const models::Facets& facets, std::size_t copies = 1) {
  return {{std::make_shared<const HeightIndex>(facets)},
          std::vector(copies, PixelMap::true_scale(kDisplay, Point{0, 0}))};
}

std::uint64_t memory_for_sections_of(const PlateModel& model) {
  return memory_for_sections({&model, 1}, false);
}

}  // namespace

TEST_CASE("The memory estimate grows with the number of facets and never overflows") {
  CHECK(memory_of({binary(0)}) == 0);
  CHECK(memory_of({binary(2'000'000)}) == 2 * memory_of({binary(1'000'000)}));
  CHECK(memory_of({binary(0xFFFFFFFF)}) > 400'000'000'000);
  CHECK(memory_of(std::vector(100, binary(0xFFFFFFFF, 100))) > 10'000'000'000'000);
}

TEST_CASE(
    "Models that are alike share the memory of one, and each model that is turned differently adds its own") {
  const std::uint64_t alone = memory_of({binary(1'000'000)});
  CHECK(memory_of({binary(1'000'000, 2)}) == alone + 48'000'000);
  // Models are inspected one at a time.
  CHECK(memory_of({binary(1'000'000), binary(1'000'000)}) == alone + 48'000'000);
}

TEST_CASE("A text file is in memory completely while it is read") {
  constexpr std::uint64_t kBytes = 10'000'000'000;
  CHECK(memory_of({FileToRead{{.most_facets = 1, .buffered_bytes = kBytes}}}) >= kBytes);
}

TEST_CASE("A larger display takes more memory") {
  constexpr DisplayGeometry kLarge{Pixels{3840}, Pixels{2160}, Micrometers{50}};
  CHECK(memory_for_display(kLarge) > memory_for_display(kDisplay) + 3 * 1920 * 1080);
}

TEST_CASE("The memory for sections depends on the height that crosses the most facets") {
  // 1,000 needles of four facets side by side, or one above the other.
  models::Facets beside, above;
  for (int i = 0; i < 1000; ++i) {
    const auto at = static_cast<float>(i);
    const models::Facets needle = models::box({at, 0, 0}, {at + 0.5F, 1, 10});
    beside.insert(beside.end(), needle.begin(), needle.end());
    const models::Facets stacked = models::box({0, 0, at}, {1, 1, at + 0.5F});
    above.insert(above.end(), stacked.begin(), stacked.end());
  }
  const PlateModel all_at_once = plate_model(beside), one_by_one = plate_model(above);
  CHECK(memory_for_sections_of(all_at_once) > 100 * memory_for_sections_of(one_by_one));
  CHECK(memory_for_sections_of(all_at_once) <= most_memory_for_sections({&all_at_once, 1}, false));
  CHECK(memory_for_sections_of(plate_model(beside, 10)) > 2 * memory_for_sections_of(all_at_once));
  const std::vector<PlateModel> ten(10, all_at_once);
  // Ten models keep ten cuts, ten copies of one model keep one.
  CHECK(memory_for_sections(ten, false) > memory_for_sections_of(plate_model(beside, 10)));
  CHECK(memory_for_sections(ten, false) < 2 * memory_for_sections_of(plate_model(beside, 10)));
  CHECK(memory_for_sections({&all_at_once, 1}, true) > 2 * memory_for_sections_of(all_at_once));
}

TEST_CASE("JobTooLarge states the figures and whether the job would fit if contourd held nothing else") {
  const std::vector<FileToRead> files{binary(1'300'000), {{.most_facets = 20, .buffered_bytes = 1500}, 1}};
  const MemoryRoom room{.bytes = 200'000'000, .reason = "the reason", .held = 300'000'000};
  const JobTooLarge now(files, "", 450'000'000, room);
  CHECK(now.fits_alone());
  CHECK(std::string(now.what()) ==
        "the models hold up to 1300020 facets, for which 450 MB of memory are needed, and there is room for "
        "200 MB: the reason");
  CHECK_FALSE(JobTooLarge(files, "", 501'000'000, room).fits_alone());
}
