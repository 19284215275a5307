#include "daemon/jobs/incoming_router.hpp"

#include "tests/catch.hpp"
#include "tests/daemon/jobs/fake_printer.hpp"
#include "tests/daemon/jobs/printer_fixture.hpp"

namespace {

class RouterFixture {
 public:
  EventLoop loop;
  testing::LogText text{loop};
  PrinterConfig config;
  testing::FakeChecks work;
  testing::FakeQueueObserver observer;
  PrintQueue queue{config, work, observer, text.log};
  IncomingRouter router{text.log, queue};
};

}  // namespace

TEST_CASE("A job that arrives in incoming/ is queued, and one that is removed leaves the queue") {
  RouterFixture fixture;
  fixture.router.model_arrived("part.stl");
  CHECK(fixture.queue.jobs().size() == 1);
  fixture.router.model_withdrawn("part.stl");
  CHECK(fixture.queue.empty());
}

TEST_CASE("Files that will not be printed are logged, with names made safe for a terminal") {
  RouterFixture fixture;
  fixture.router.plate_waits("plate\x1b[2J", {"a.stl", "b\x1b.stl"});
  CHECK(fixture.text.has("info: plate?[2J: waits for a.stl, b?.stl, which its plate.json names"));
  fixture.router.ignored("old\x1b.zip", WhyIgnored::Archive);
  CHECK(fixture.text.has("warning: old?.zip: is ignored: " + std::string(sentence_for(WhyIgnored::Archive))));
  fixture.router.more_ignored(7);
  CHECK(fixture.text.has("warning: 7 more in incoming are ignored"));
  CHECK(fixture.queue.empty());
}

TEST_CASE("The loss or replacement of incoming/ is logged") {
  RouterFixture fixture;
  fixture.router.incoming_lost("it is a file");
  CHECK(fixture.text.has("error: nothing arrives until there is an incoming folder again: it is a file"));
  fixture.router.incoming_replaced();
  CHECK(fixture.text.has("warning: incoming was removed, replaced or mounted over"));
}
