#include "daemon/web/hosts/host_jobs.hpp"

#include <algorithm>
#include <string_view>

#include "daemon/web/hosts/host_printer.hpp"
#include "daemon/web/page/page_methods.hpp"
#include "tests/catch.hpp"

using namespace contourd::web;

namespace {

using Json = ControlLink::Json;

Json status_in(const char* state, Json job = nullptr) {
  return {{"printer", "p"},        {"state", state},
          {"job", std::move(job)}, {"dark", std::string_view(state) != "exposing"},
          {"last", nullptr},       {"held", nullptr}};
}

Json print_of(const char* name) {
  return {{"name", name},           {"layer", 3},       {"layers", 9},
          {"height_mm", 0.15},      {"elapsed_s", 5.5}, {"time_left_s", 10.5},
          {"layer_height_um", 50.0}};
}

}  // namespace

TEST_CASE("The number of a name stays the same, differs from others and fits any client") {
  CHECK(id_of("gear") == id_of("gear"));
  CHECK(id_of("gear") != id_of("gear (2)"));
  for (const char* name : {"", "a", "gear", "\xC3\xA4"})
    CHECK((id_of(name) > 0 && id_of(name) < (1U << 31U)));
}

TEST_CASE("The phase of a print follows contourd's states") {
  HostStatusReader reader;
  const auto phase = [&reader](const char* state, bool pause_pending = false) {
    Json job = print_of("gear");
    job["pause_pending"] = pause_pending;
    return reader.read(status_in(state, job)).phase;
  };
  CHECK(reader.read(status_in("idle")).phase == HostPhase::Idle);
  CHECK(reader.read(status_in("preparing", {{"name", "gear"}})).phase == HostPhase::Starting);
  CHECK(phase("warming up") == HostPhase::Starting);
  CHECK(phase("exposing") == HostPhase::Printing);
  CHECK(phase("rising") == HostPhase::Printing);
  CHECK(phase("exposing", true) == HostPhase::Pausing);
  CHECK(phase("raising") == HostPhase::Pausing);
  CHECK(phase("paused") == HostPhase::Paused);
  CHECK(phase("halting") == HostPhase::Cancelling);
  CHECK(phase("parking") == HostPhase::Starting);
}

TEST_CASE("A print that a client has cancelled is being cancelled until it has ended") {
  HostStatusReader reader;
  (void)reader.read(status_in("exposing", print_of("gear")));
  reader.is_cancelled();
  CHECK(reader.read(status_in("parking", print_of("gear"))).phase == HostPhase::Cancelling);
  CHECK(reader.read(status_in("idle")).phase == HostPhase::Idle);
  CHECK(reader.read(status_in("exposing", print_of("gear"))).phase == HostPhase::Printing);
}

TEST_CASE("A print and one that was done have their layers, and one that was cancelled has none") {
  HostStatusReader reader;
  const HostStatus during = reader.read(status_in("exposing", print_of("gear")));
  CHECK((during.layer == 3 && during.layers == 9 && during.is_lit && during.height_mm == 0.15));
  CHECK((during.job && during.job->print_time_s == 16 && during.time_left_s == 10.5));
  const HostStatus filed = reader.read(status_in("finishing", {{"name", "gear"}}));
  CHECK((filed.layer == 3 && filed.layers == 9 && filed.height_mm == 0.15));
  CHECK((filed.job && filed.job->print_time_s == 16 && filed.job->layers == 9));
  Json ended = status_in("idle");
  ended["last"] = {{"job", "gear"}, {"outcome", "done"}, {"reason", ""}};
  CHECK(reader.read(ended).layer == 9);
  ended["last"]["outcome"] = "cancelled";
  CHECK_FALSE(reader.read(ended).layer);
  ended["last"] = {{"job", "other"}, {"outcome", "done"}, {"reason", ""}};
  CHECK_FALSE(reader.read(ended).layer);
}

TEST_CASE("The text of the status has the reason for which the printer waits or has failed") {
  HostStatusReader reader;
  CHECK(reader.read(status_in("exposing", print_of("gear"))).text == "exposing");
  Json status = status_in("idle");
  status["last"] = {{"job", "gear"}, {"outcome", "failed"}, {"reason", "no facets"}};
  CHECK(reader.read(status).text == "gear failed: no facets");
  status["held"] = "the lid was opened";
  CHECK(reader.read(status).text == "the lid was opened");
}

TEST_CASE("Waiting jobs follow the print under way, with what is known of them") {
  const Json queue{{"jobs",
                    {{{"job", "a"}, {"file", "a.stl"}, {"state", "unchecked"}, {"layers", nullptr}},
                     {{"job", "b"}, {"file", "b.sl1"}, {"state", "unaccepted"}, {"layers", 7}}}}};
  const std::vector<HostJob> jobs = host_jobs(status_in("exposing", print_of("gear")), queue);
  REQUIRE(jobs.size() == 3);
  CHECK((jobs[0].is_printing && jobs[0].file == "gear" && jobs[0].layer_um == 50));
  CHECK((!jobs[1].is_printing && jobs[1].layers == 0 && jobs[1].state == "unchecked"));
  CHECK((jobs[2].file == "b.sl1" && jobs[2].layers == 7 && jobs[2].id() == id_of("b")));
  CHECK(host_jobs(Json::object(), Json::object()).empty());
}

TEST_CASE("Other hosts' interfaces call only methods that the role print may call") {
  constexpr std::array<std::string_view, 3> kReports{"mask", "methods", "preview"};
  for (const std::string_view name : kHostMethods) {
    const PageMethod* const method = page_method(name);
    const PageQuery* const query = page_query(name);
    CHECK(((method != nullptr && method->least <= Role::Print) ||
           (query != nullptr && query->least <= Role::Print) ||
           std::ranges::find(kReports, name) != kReports.end()));
  }
  CHECK(page_method(kHostStop)->least <= Role::Print);
}

TEST_CASE("A job that is being removed is no longer one of the jobs") {
  const Json queue{{"jobs",
                    {{{"job", "gone"}, {"file", "gone.stl"}, {"state", "leaving"}},
                     {{"job", "gear"}, {"file", "gear.stl"}, {"state", "ready"}}}}};
  const std::vector<HostJob> jobs = host_jobs(status_in("idle"), queue);
  REQUIRE(jobs.size() == 1);
  CHECK(jobs.front().name == "gear");
}
