#include "daemon/spool/reading_record.hpp"

#include <fstream>

#include "tests/catch.hpp"
#include "tests/temporary_folder.hpp"

namespace fs = std::filesystem;

namespace {

// A state folder and two models.
class ReadingRecordFixture {
 public:
  [[nodiscard]] fs::path record() const { return folder_.path() / "reading"; }
  // Leaves the record of a process that ends while it reads the job.
  void die_reading(const JobFiles& job) {
    const fs::path kept = folder_.path() / "kept";
    {
      ReadingRecord dying(record());
      const ReadingRecord::Reading under_way(dying, job);
      fs::copy_file(record(), kept);
    }
    fs::rename(kept, record());
  }
  [[nodiscard]] std::string text() const {
    std::ifstream file(record());
    return {std::istreambuf_iterator<char>(file), {}};
  }

 private:
  testing::TemporaryFolder folder_;

 public:
  const JobFiles part{"part", folder_.write("part.stl", "one"), std::nullopt};
  const JobFiles other{"other", folder_.write("other.stl", "another"), std::nullopt};
};

}  // namespace

TEST_CASE("The model that a process was reading when it ended is reported once to the next process") {
  ReadingRecordFixture fixture;
  fixture.die_reading(fixture.part);
  ReadingRecord next(fixture.record());
  CHECK_FALSE(next.take_ended(fixture.other));
  CHECK(next.take_ended(fixture.part));
  CHECK_FALSE(next.take_ended(fixture.part));
  CHECK_FALSE(fs::exists(fixture.record()));
}

TEST_CASE("A finished reading leaves no record") {
  ReadingRecordFixture fixture;
  {
    ReadingRecord record(fixture.record());
    { const ReadingRecord::Reading under_way(record, fixture.part); }
    CHECK_FALSE(fs::exists(fixture.record()));
  }
  CHECK_FALSE(ReadingRecord(fixture.record()).take_ended(fixture.part));
}

TEST_CASE("A model stays in the record while others are read, also if further processes end") {
  ReadingRecordFixture fixture;
  fixture.die_reading(fixture.part);
  fixture.die_reading(fixture.other);
  {
    ReadingRecord record(fixture.record());
    const ReadingRecord::Reading under_way(
        record, JobFiles{"third", fixture.record().parent_path() / "none.stl", std::nullopt});
  }
  ReadingRecord next(fixture.record());
  CHECK(next.take_ended(fixture.part));
  CHECK(next.take_ended(fixture.other));
}

TEST_CASE("A model that was moved is the same, and one that was written again is not") {
  ReadingRecordFixture fixture;
  fixture.die_reading(fixture.part);
  const JobFiles moved{"part-2", fixture.part.model.parent_path() / "part-2.stl", std::nullopt};
  fs::rename(fixture.part.model, moved.model);
  fixture.die_reading(fixture.other);
  std::ofstream(fixture.other.model, std::ios::app) << "more";
  ReadingRecord next(fixture.record());
  CHECK(next.take_ended(moved));
  CHECK_FALSE(next.take_ended(fixture.other));
}

TEST_CASE("A requested stop during a reading leaves no record") {
  ReadingRecordFixture fixture;
  ReadingRecord record(fixture.record());
  const ReadingRecord::Reading under_way(record, fixture.part);
  record.stop();
  CHECK_FALSE(fs::exists(fixture.record()));
  const ReadingRecord::Reading after_it(record, fixture.other);
  CHECK_FALSE(fs::exists(fixture.record()));
}

TEST_CASE("A record of an earlier boot is ignored") {
  ReadingRecordFixture fixture;
  fixture.die_reading(fixture.part);
  std::string text = fixture.text();
  text[0] = text[0] == '0' ? '1' : '0';  // the ID of another boot
  std::ofstream(fixture.record()) << text;
  CHECK_FALSE(ReadingRecord(fixture.record()).take_ended(fixture.part));
}

TEST_CASE("Only complete lines of a damaged record count") {
  ReadingRecordFixture fixture;
  fixture.die_reading(fixture.part);
  const std::string text = fixture.text();
  for (std::size_t bytes = 0; bytes + 1 < text.size(); ++bytes) {
    std::ofstream(fixture.record()) << text.substr(0, bytes);
    CHECK_FALSE(ReadingRecord(fixture.record()).take_ended(fixture.part));
  }
  std::ofstream(fixture.record()) << text;
  CHECK(ReadingRecord(fixture.record()).take_ended(fixture.part));
  fs::remove(fixture.record());
  fs::create_directory(fixture.record());
  ReadingRecord record(fixture.record());
  CHECK_FALSE(record.take_ended(fixture.part));
  const ReadingRecord::Reading under_way(record, fixture.part);
}
