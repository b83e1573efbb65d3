// Tests of experiments in child processes.
#include "renderer/doctor/child.h"

#include <gtest/gtest.h>
#include <signal.h>
#include <unistd.h>

#include <cstdlib>
#include <stdexcept>
#include <string>

namespace fire3dv::doctor {
namespace {

constexpr std::chrono::seconds kLong{200};

TEST(Child, ValuesAndErrorsArrive) {
  const ChildResult value = run_in_child([] { return nlohmann::json{{"answer", 42}}; }, kLong);
  EXPECT_TRUE(value.trial.passed());
  EXPECT_EQ(value.value.at("answer"), 42);
  const ChildResult error =
      run_in_child([]() -> nlohmann::json { throw std::runtime_error("no \xff device"); }, kLong);
  EXPECT_EQ(error.trial.outcome, Outcome::failed);
  EXPECT_EQ(error.trial.detail.substr(0, 3), "no ");
}

TEST(Child, LongAnswersArrive) {
  const std::string text(300'000, 'x');
  EXPECT_EQ(run_in_child([&] { return nlohmann::json(text); }, kLong).value, text);
}

TEST(Child, ACrashIsNamedByItsSignal) {
  const ChildResult result = run_in_child(
      []() -> nlohmann::json {
        ::signal(SIGABRT, SIG_DFL);
        ::raise(SIGKILL);
        return true;
      },
      kLong);
  EXPECT_EQ(result.trial.outcome, Outcome::crashed);
  EXPECT_EQ(result.trial.detail, "SIGKILL");
}

TEST(Child, AnEndWithoutAnAnswerIsACrash) {
  const ChildResult result = run_in_child([]() -> nlohmann::json { ::_exit(3); }, kLong);
  EXPECT_EQ(result.trial.outcome, Outcome::crashed);
  EXPECT_EQ(result.trial.detail, "exit status 3");
}

TEST(Child, AParentThatIgnoresItsChildrenGetsTheirAnswers) {
  ::signal(SIGCHLD, SIG_IGN);
  EXPECT_TRUE(run_in_child([] { return nlohmann::json(1); }, kLong).trial.passed());
  EXPECT_EQ(::signal(SIGCHLD, SIG_DFL), SIG_IGN);
}

TEST(Child, ATimeLimitIsNamedInFull) {
  const ChildResult result = run_in_child(
      []() -> nlohmann::json {
        ::pause();
        return true;
      },
      std::chrono::milliseconds(1234));
  EXPECT_EQ(result.trial.detail, "1.234 s");
}

TEST(Child, AChildThatHangsIsKilledWithItsOwnChildren) {
  int ends[2];
  ASSERT_EQ(::pipe(ends), 0);
  const ChildResult result = run_in_child(
      []() -> nlohmann::json {
        if (::fork() == 0) ::pause();
        ::pause();
        return true;
      },
      std::chrono::milliseconds(300));
  EXPECT_EQ(result.trial.outcome, Outcome::hung);
  EXPECT_EQ(result.trial.detail, "0.3 s");
  ::close(ends[1]);
  char byte = 0;
  EXPECT_EQ(::read(ends[0], &byte, 1), 0);  // nobody holds the other end any more
  ::close(ends[0]);
}

}  // namespace
}  // namespace fire3dv::doctor
