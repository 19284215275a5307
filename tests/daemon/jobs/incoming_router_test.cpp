#include "daemon/jobs/incoming_router.hpp"

#include <string>

#include "tests/catch.hpp"
#include "tests/daemon/jobs/printer_fixture.hpp"

using namespace contourd;

namespace {

class Desk {
 public:
  EventLoop loop;
  testing::LogText text{loop};
  PrintQueue queue{text.log,
                   {.check = [](const std::string&, JobReader::Keep, const auto&) {},
                    .forget = [](const std::string&) {},
                    .reject = [](const std::string&, const std::string&, const Spool::Rejected&) {},
                    .changed = [] {},
                    .refused = [](const std::string&, const std::string&) {},
                    .removed = [](const std::string&, const std::string&) {},
                    .keep_order = [](const QueueOrder::Names&, const auto&) {}}};
  IncomingRouter log{text.log, queue};
};

}  // namespace

TEST_CASE("What arrives in incoming/ is queued, and what goes leaves the queue") {
  Desk desk;
  desk.log.model_arrived("part.stl");
  CHECK(desk.queue.jobs().size() == 1);
  desk.log.model_withdrawn("part.stl");
  CHECK(desk.queue.empty());
}

TEST_CASE("What will not be printed as it is is told, and names do nothing to a terminal") {
  Desk desk;
  desk.log.plate_waits("plate\x1b[2J", {"a.stl", "b\x1b.stl"});
  CHECK(desk.text.has("info: plate?[2J: waits for a.stl, b?.stl, which its plate.json names"));
  desk.log.ignored("old\x1b.zip", WhyIgnored::Archive);
  CHECK(desk.text.has("warning: old?.zip: is ignored: " + std::string(sentence_for(WhyIgnored::Archive))));
  desk.log.more_ignored(7);
  CHECK(desk.text.has("warning: 7 more in incoming are ignored"));
  CHECK(desk.queue.empty());
}

TEST_CASE("That incoming/ was lost or replaced is told") {
  Desk desk;
  desk.log.incoming_lost("it is a file");
  CHECK(desk.text.has("error: nothing arrives until there is an incoming folder again: it is a file"));
  desk.log.incoming_replaced();
  CHECK(desk.text.has("warning: incoming was removed, replaced or mounted over"));
}
