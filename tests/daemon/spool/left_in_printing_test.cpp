#include "daemon/spool/job_moves.hpp"

#include "tests/catch.hpp"
#include "tests/daemon/spool/spool_fixture.hpp"

namespace {

class LeftInPrintingFixture : public testing::SpoolFixture {
 public:
  // Returns the names of the jobs found, sorted.
  [[nodiscard]] std::vector<std::string> left() const {
    std::vector<std::string> names;
    for (const JobFiles& job : jobs_left_in_printing(folders))
      names.push_back(job.name + (job.ticket ? " with its ticket" : ""));
    std::ranges::sort(names);
    return names;
  }
};

using Names = std::vector<std::string>;

}  // namespace

TEST_CASE("Models and plates in printing/ are found with their tickets") {
  const LeftInPrintingFixture fixture;
  fixture.put("printing/one.stl");
  fixture.put("printing/one.json", "{}");
  fixture.put("printing/plate/plate.json", "{}");
  CHECK(fixture.left() == Names{"one with its ticket", "plate"});
}

TEST_CASE("A ticket that was not moved after its model is moved now") {
  const LeftInPrintingFixture fixture;
  fixture.put("incoming/part.json", "{}");
  // The model must be newer by the kernel's clock for files, which ticks every few milliseconds.
  fixture.put("printing/part.stl");
  for (int i = 0; i < 1'000'000 && fixture.has("incoming/part.json") && fixture.left() == Names{"part"}; ++i)
    fixture.put("printing/part.stl");
  CHECK(fixture.has("printing/part.json"));
  CHECK(fixture.left() == Names{"part with its ticket"});
}

TEST_CASE("A ticket that came after its model was moved to printing/ stays in incoming/") {
  const LeftInPrintingFixture fixture;
  fixture.put("printing/part.stl");
  fixture.put("incoming/part.stl");
  fixture.put("incoming/part.json", "{}");
  CHECK(fixture.left() == Names{"part"});
  CHECK(fixture.has("incoming/part.json"));
}

TEST_CASE("A ticket without a job goes to its model's folder, any other file to failed/") {
  const LeftInPrintingFixture fixture;
  fixture.put("printing/waits.json", "{}");
  fixture.put("incoming/waits.stl");
  fixture.put("printing/done.json", "{}");
  fixture.put("done/done.stl");
  fixture.put("printing/both.json", "{}");
  fixture.put("done/both.stl");
  fixture.put("done/both.json", "{}");
  fixture.put("printing/notes.txt");
  CHECK(fixture.left().empty());
  CHECK(fixture.has("incoming/waits.json"));
  CHECK(fixture.has("done/done.json"));
  CHECK(fixture.has("failed/both.json"));
  CHECK(fixture.has("failed/notes.txt"));
}

TEST_CASE("A file that belongs to no job replaces no file in failed/") {
  const LeftInPrintingFixture fixture;
  fixture.put("printing/notes.txt", "newer");
  fixture.put("failed/notes.txt", "older");
  CHECK(fixture.left().empty());
  CHECK(fixture.text_of("failed/notes.txt") == "older");
  CHECK(fixture.text_of("printing/notes.txt") == "newer");
}
