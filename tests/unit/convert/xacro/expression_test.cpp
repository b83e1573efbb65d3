// Test of xacro's expressions against values that the program xacro (Python 3.11) gives for them, and of
// refusals.
#include <gtest/gtest.h>

#include <string>
#include <utility>

#include "convert/xacro/expression/expression.h"
#include "convert/xacro/expression/functions.h"

namespace fire3dv::convert::xacro {
namespace {

class NoProperties : public Environment {
 public:
  std::optional<Value> property(Scope*, const std::string&) override { return std::nullopt; }
  std::string argument(const std::string& name) override { return "argument " + name; }
  Value load_yaml(const std::string&) override { return {}; }
  std::string absolute_path(const std::string& path) override { return path; }
  void message(const std::string&, const std::string&) override {}
};

std::string value_of(const std::string& text) {
  NoProperties environment;
  Budget budget;
  try {
    return text_of(evaluate(*parse_expression(text), environment, budget), budget);
  } catch (const Failure& failure) {
    return "failure: " + failure.message();
  }
}

constexpr std::pair<const char*, const char*> kValues[] = {
    {"1+2*3", "7"},
    {"-2**2", "-4"},
    {"2**-1", "0.5"},
    {"2**10", "1024"},
    {"7//2", "3"},
    {"-7//2", "-4"},
    {"-7%3", "2"},
    {"7.5//2", "3.0"},
    {"-7.5%2", "0.5"},
    {"7/2", "3.5"},
    {"6/3", "2.0"},
    {"1e3", "1000.0"},
    {"1e-5", "1e-05"},
    {"0.1+0.2", "0.30000000000000004"},
    {"1e16", "1e+16"},
    {"123456789012345678.0", "1.2345678901234568e+17"},
    {"5e-324", "5e-324"},
    {"True+1", "2"},
    {"not 0", "True"},
    {"1<2<3", "True"},
    {"3>2>2", "False"},
    {"1==1.0", "True"},
    {"'a'=='a' and 'b' or 'c'", "b"},
    {"0 or ''", ""},
    {"'x' if 2 in [1,2] else 'y'", "x"},
    {"'l' in 'left'", "True"},
    {"3 not in (1,2)", "True"},
    {"None is None", "True"},
    {"'%s_%02d_%.2f' % ('a', 7, 3.14159)", "a_07_3.14"},
    {"'arm' + '_' + str(2)", "arm_2"},
    {"'ab'*3", "ababab"},
    {"[1]*3", "[1, 1, 1]"},
    {"[1,2]+[3]", "[1, 2, 3]"},
    {"(1,)", "(1,)"},
    {"(1,'a')", "(1, 'a')"},
    {"[1,2,3][-1]", "3"},
    {"'left'[1:]", "eft"},
    {"[1,2,3,4][::2]", "[1, 3]"},
    {"'abc'[::-1]", "cba"},
    {"dict(a=1,b=[2.5])['b'][0]", "2.5"},
    {"dict(a=1).get('z', 4)", "4"},
    {"len('abc')", "3"},
    {"int('0x1f', 16) if False else int('31')", "31"},
    {"int(3.9)", "3"},
    {"float('1e-3')", "0.001"},
    {"round(2.5)", "2"},
    {"round(3.5)", "4"},
    {"round(2.675, 2)", "2.67"},
    {"round(1234.5678, -2)", "1200.0"},
    {"min(3, 1.5, 2)", "1.5"},
    {"max([1, 5, 2])", "5"},
    {"python.abs(-3.5)", "3.5"},
    {"list(range(2, 9, 3))", "[2, 5, 8]"},
    {"python.sorted([3, 1, 2])", "[1, 2, 3]"},
    {"list(map(float, ['1', '2']))", "[1.0, 2.0]"},
    {"sin(pi/6)", "0.49999999999999994"},
    {"math.cos(0)", "1.0"},
    {"degrees(pi)", "180.0"},
    {"radians(90)", "1.5707963267948966"},
    {"atan2(1, -1)", "2.356194490192345"},
    {"sqrt(2)", "1.4142135623730951"},
    {"hypot(3, 4)", "5.0"},
    {"floor(-1.5)", "-2"},
    {"ceil(1.2)", "2"},
    {"'a,b;c d'.split(',')", "['a', 'b;c d']"},
    {"'Left_ARM'.lower()", "left_arm"},
    {"' x '.strip()", "x"},
    {"'-'.join(['a', 'b'])", "a-b"},
    {"'arm'.startswith('ar')", "True"},
    {"'a.b.c'.replace('.', '/')", "a/b/c"},
    {"xacro.tokenize('1,2;3')", "['1', '2', '3']"},
    {"1 if 0 else 2 if 0 else 3", "3"},
    {"5 & 3 | 8", "9"},
    {"1 << 4", "16"},
    {"~5", "-6"},
    {"0b101 + 0x1F", "36"},
    {"+3 - -2", "5"},
    {R"("it's")", "it's"},
    {R"(["it's", 'b'])", "[\"it's\", 'b']"},
    {"u'text'", "text"},
    {"'a' 'b'", "ab"},
    {"python.isinstance('a', str)", "True"},
    {"python.set([3, 1, 3])", "{3, 1}"},
    {"python.set()", "set()"},
    {"python.set('ab') - python.set('b')", "{'a'}"},
    {"python.set([1, 2]) & python.set([2, 3])", "{2}"},
    {"python.set([1]) | python.set([2])", "{1, 2}"},
    {"python.set([1, 2]) ^ python.set([2, 3])", "{1, 3}"},
    {"python.set([1, 2]) == python.set([2, 1])", "True"},
    {"2 in python.set([1, 2])", "True"},
    {"len(python.set([1, 1]))", "1"},
    {"1_000", "1000"},
};

TEST(XacroExpression, ValuesAreThoseOfPython) {
  for (const auto& [text, expected] : kValues) EXPECT_EQ(value_of(text), expected) << text;
}

TEST(XacroExpression, WhatPythonRefusesIsRefused) {
  for (const auto& [text, reason] : std::initializer_list<std::pair<const char*, const char*>>{
           {"1/0", "division by zero"},
           {"7 % 0", "division by zero"},
           {"1.5 // 0", "division by zero"},
           {"'a' + 1", "a str and a int have no operator +"},
           {"1 < 'a'", "have no order"},
           {"[1][3]", "beyond the 1 items"},
           {"unknown * 2", "the name unknown is not defined"},
           {"sqrt(-1)", "not defined for this number"},
           {"int('a')", "finds no integer"},
           {"1 +", "ends too early"},
           {"(1, 2", "')' is missing at the end"},
           {"2 3", "unexpected 3"},
           {"5m", "multiplication sign"},
           {"'abc", "no closing quote"},
           {"", "empty"},
           {"9223372036854775807 + 1", "exceeds 64 bits"},
           {"-9223372036854775807 - 1 - 1", "exceeds 64 bits"},
           {"(-9223372036854775807 - 1) // -1", "exceeds 64 bits"},
           {"1 << 63", "exceeds 64 bits"},
           {"10 ** 20", "exceeds 64 bits"},
           {"dict(a=1)['b']", "no key 'b'"},
           {"xacro.fatal('no', 2)", "no 2"},
           {"'%d' % 'a'", "needs an integer"},
           {"'%s' % (1, 2)", "more values"},
           {"round(1e300)", "no integer of 64 bits"},
       })
    EXPECT_NE(value_of(text).find(reason), std::string::npos) << text << " -> " << value_of(text);
}

TEST(XacroExpression, OtherPythonIsRefused) {
  for (const char* text : {"lambda x: x", "[x for x in [1]]", "(x for x in [1])", "len(*[1])", "''.__class__",
                           "__import__('os')", "f'{1}'", "'a'.encode()", "math.gamma(2)", "python.eval('1')"})
    EXPECT_NE(value_of(text).find("is Python that fire3dv-convert does not evaluate"), std::string::npos)
        << text << " -> " << value_of(text);
}

TEST(XacroExpression, WorkIsBounded) {
  const auto repeated = [](const std::string& part, size_t count) {
    std::string text;
    for (size_t i = 0; i < count; ++i) text += part;
    return text;
  };
  for (const std::string text :
       {"'a' * 999999999999", "[0] * 999999999999", "range(99999999999)", "'%999999d' % 1",
        "len('abcdefgh' * 9999999 * 9999999)", "sum(range(9999999999))"})
    EXPECT_TRUE(value_of(text).starts_with("failure: ")) << text;
  EXPECT_TRUE(value_of(repeated("(", 5000) + "1").find("nested more than") != std::string::npos);
  EXPECT_TRUE(value_of(repeated("-", 5000) + "1").find("nested more than") != std::string::npos);
  EXPECT_TRUE(value_of(repeated("not ", 4000) + "1").find("nested more than") != std::string::npos);
  EXPECT_TRUE(value_of(repeated("1+", 5000) + "1").find("nested more than") != std::string::npos);
  EXPECT_TRUE(value_of(repeated("2**", 5000) + "1").find("nested more than") != std::string::npos);
  EXPECT_TRUE(value_of(repeated("[", 5000)).find("nested more than") != std::string::npos);
  EXPECT_TRUE(value_of(repeated("1 if 1 else ", 1300) + "1").find("nested more than") != std::string::npos);
  EXPECT_TRUE(value_of("'" + repeated("a", 20'000) + "'").find("more than 16384 characters") !=
              std::string::npos);
}

// Damaged expressions give a value or a failure.
TEST(XacroExpression, DamagedTextHarmsNobody) {
  uint32_t random = 1;
  const auto next = [&] { return (random = random * 1664525 + 1013904223) >> 8; };
  size_t failures = 0, values = 0;
  for (const auto& [text, expected] : kValues) {
    for (int round = 0; round < 60; ++round) {
      std::string damaged = text;
      for (int k = 0; k < 1 + round / 20; ++k)
        damaged[next() % damaged.size()] = "0123456789.()[]'\"+-*/%<>=!&|^~,: abcxyz_"[next() % 44];
      if (round % 3 == 0) damaged.resize(next() % damaged.size());
      ++(value_of(damaged).starts_with("failure: ") ? failures : values);
    }
  }
  EXPECT_GT(failures, 500u);
  EXPECT_GT(values, 500u);
}

}  // namespace
}  // namespace fire3dv::convert::xacro
