#include "daemon/history/vat.hpp"

#include "tests/catch.hpp"
#include "tests/daemon/jobs/printer_fixture.hpp"

namespace {

class VatFixture : public testing::PrinterFixture {
 public:
  void fill(double ml) {
    vat.fill(ml, [](const std::string&) {});
  }

  Vat vat{spool};
};

}  // namespace

TEST_CASE_METHOD(VatFixture, "A vat that no user has filled holds an unknown amount, and never warns") {
  vat.load();
  CHECK_FALSE(vat.ml());
  CHECK(vat.use(1000).empty());
  CHECK_FALSE(vat.ml());
}

TEST_CASE_METHOD(VatFixture,
                 "A vat warns once when it is low and once when it is empty, until it is filled again") {
  fill(20);
  CHECK(vat.use(9.5).empty());
  CHECK(vat.use(1).starts_with("the vat holds about 10 ml of resin: fill it, "));
  CHECK(vat.use(1).empty());
  CHECK_FALSE(vat.use(100).empty());
  CHECK(vat.ml() == 0);
  CHECK(vat.use(1).empty());
  fill(20);
  CHECK_FALSE(vat.use(11).empty());
}

TEST_CASE_METHOD(VatFixture,
                 "A vat's resin survives a restart, and a record that is no number does not count") {
  fill(150.5);
  CHECK(vat.use(20.25).empty());
  Vat again(spool);
  REQUIRE(run_until([&] {
    again.load();
    return again.ml() == 130.25;
  }));
  for (const char* text : {"many", "-1", "nan", "12 ml", ""}) {
    spool.records().set_vat(text);
    Vat odd(spool);
    odd.load();
    CHECK_FALSE(odd.ml());
  }
}
