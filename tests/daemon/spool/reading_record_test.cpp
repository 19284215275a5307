#include "daemon/spool/reading_record.hpp"

#include <fstream>
#include <optional>
#include <string>

#include "tests/catch.hpp"
#include "tests/temporary_folder.hpp"

using namespace contourd;
namespace fs = std::filesystem;

namespace {

// A state folder and two models.
class Desk {
 public:
  [[nodiscard]] fs::path record() const { return folder_.path() / "reading"; }
  // What a process leaves that ends while it reads this.
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

TEST_CASE("What a process was reading when it ended is known to the next one, once") {
  Desk desk;
  desk.die_reading(desk.part);
  ReadingRecord next(desk.record());
  CHECK_FALSE(next.take_ended(desk.other));
  CHECK(next.take_ended(desk.part));
  CHECK_FALSE(next.take_ended(desk.part));
  CHECK_FALSE(fs::exists(desk.record()));
}

TEST_CASE("A reading that came to its end leaves nothing") {
  Desk desk;
  {
    ReadingRecord record(desk.record());
    { const ReadingRecord::Reading under_way(record, desk.part); }
    CHECK_FALSE(fs::exists(desk.record()));
  }
  CHECK_FALSE(ReadingRecord(desk.record()).take_ended(desk.part));
}

TEST_CASE("A model stays known while others are read, over as many ends as there are") {
  Desk desk;
  desk.die_reading(desk.part);
  desk.die_reading(desk.other);
  {
    ReadingRecord record(desk.record());
    const ReadingRecord::Reading under_way(
        record, JobFiles{"third", desk.record().parent_path() / "none.stl", std::nullopt});
  }
  ReadingRecord next(desk.record());
  CHECK(next.take_ended(desk.part));
  CHECK(next.take_ended(desk.other));
}

TEST_CASE("A model that was moved is the same, and one that was written again is not") {
  Desk desk;
  desk.die_reading(desk.part);
  const JobFiles moved{"part-2", desk.part.model.parent_path() / "part-2.stl", std::nullopt};
  fs::rename(desk.part.model, moved.model);
  desk.die_reading(desk.other);
  std::ofstream(desk.other.model, std::ios::app) << "more";
  ReadingRecord next(desk.record());
  CHECK(next.take_ended(moved));
  CHECK_FALSE(next.take_ended(desk.other));
}

TEST_CASE("A stop that was asked for is no end in the middle of a reading") {
  Desk desk;
  ReadingRecord record(desk.record());
  const ReadingRecord::Reading under_way(record, desk.part);
  record.stop();
  CHECK_FALSE(fs::exists(desk.record()));
  const ReadingRecord::Reading after_it(record, desk.other);
  CHECK_FALSE(fs::exists(desk.record()));
}

TEST_CASE("What was read when the computer went down says nothing about a file") {
  Desk desk;
  desk.die_reading(desk.part);
  std::string text = desk.text();
  text[0] = text[0] == '0' ? '1' : '0';  // another boot's
  std::ofstream(desk.record()) << text;
  CHECK_FALSE(ReadingRecord(desk.record()).take_ended(desk.part));
}

TEST_CASE("A record that was cut off, or is none, counts for what is whole in it") {
  Desk desk;
  desk.die_reading(desk.part);
  const std::string text = desk.text();
  for (std::size_t bytes = 0; bytes + 1 < text.size(); ++bytes) {
    std::ofstream(desk.record()) << text.substr(0, bytes);
    CHECK_FALSE(ReadingRecord(desk.record()).take_ended(desk.part));
  }
  std::ofstream(desk.record()) << text;
  CHECK(ReadingRecord(desk.record()).take_ended(desk.part));
  fs::remove(desk.record());
  fs::create_directory(desk.record());
  ReadingRecord record(desk.record());
  CHECK_FALSE(record.take_ended(desk.part));
  const ReadingRecord::Reading under_way(record, desk.part);
}
