#include "daemon/spool/left_in_printing.hpp"

#include <algorithm>
#include <string>
#include <vector>

#include "tests/catch.hpp"
#include "tests/daemon/spool/spool_fixture.hpp"

using namespace contourd;

namespace {

class Desk : public testing::SpoolFixture {
 public:
  // Their names, in order.
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

TEST_CASE("Models and plates that were left are jobs, with their tickets") {
  const Desk desk;
  desk.put("printing/one.stl");
  desk.put("printing/one.json", "{}");
  desk.put("printing/plate/plate.json", "{}");
  CHECK(desk.left() == Names{"one with its ticket", "plate"});
}

TEST_CASE("A ticket that was to follow its model is brought") {
  const Desk desk;
  desk.put("incoming/part.json", "{}");
  // Its model is the newer by the kernel's clock for files, which ticks every few milliseconds.
  desk.put("printing/part.stl");
  for (int i = 0; i < 1'000'000 && desk.has("incoming/part.json") && desk.left() == Names{"part"}; ++i)
    desk.put("printing/part.stl");
  CHECK(desk.has("printing/part.json"));
  CHECK(desk.left() == Names{"part with its ticket"});
}

TEST_CASE("A ticket that came when its model was being printed already is another's") {
  const Desk desk;
  desk.put("printing/part.stl");
  desk.put("incoming/part.stl");
  desk.put("incoming/part.json", "{}");
  CHECK(desk.left() == Names{"part"});
  CHECK(desk.has("incoming/part.json"));
}

TEST_CASE("A lost ticket goes to where its model is, and what is nobody's to failed") {
  const Desk desk;
  desk.put("printing/waits.json", "{}");
  desk.put("incoming/waits.stl");
  desk.put("printing/done.json", "{}");
  desk.put("done/done.stl");
  desk.put("printing/both.json", "{}");
  desk.put("done/both.stl");
  desk.put("done/both.json", "{}");
  desk.put("printing/notes.txt");
  CHECK(desk.left().empty());
  CHECK(desk.has("incoming/waits.json"));
  CHECK(desk.has("done/done.json"));
  CHECK(desk.has("failed/both.json"));
  CHECK(desk.has("failed/notes.txt"));
}

TEST_CASE("What is nobody's takes no other file's place, but waits") {
  const Desk desk;
  desk.put("printing/notes.txt", "newer");
  desk.put("failed/notes.txt", "older");
  CHECK(desk.left().empty());
  CHECK(desk.text_of("failed/notes.txt") == "older");
  CHECK(desk.text_of("printing/notes.txt") == "newer");
}
