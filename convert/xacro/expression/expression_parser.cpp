#include <algorithm>
#include <array>
#include <utility>

#include "convert/xacro/expression/expression.h"
#include "convert/xacro/expression/expression_lexer.h"

namespace fire3dv::convert::xacro {
namespace {

constexpr size_t kMaxLength = 16384, kMaxDepth = 100;

using Node = std::unique_ptr<Expression>;
using Kind = Expression::Kind;

class Parser {
 public:
  explicit Parser(std::string_view text) : lexer_(text) { advance(); }

  Node parse() {
    if (token_.kind == TokenKind::end) throw Failure("the expression is empty");
    Node node = tuple_or_single();
    if (token_.kind != TokenKind::end) unexpected();
    return node;
  }

 private:
  void advance() { token_ = lexer_.next(); }
  bool is_symbol(std::string_view text) const {
    return token_.kind == TokenKind::symbol && token_.text == text;
  }
  bool is_name(std::string_view text) const { return token_.kind == TokenKind::name && token_.text == text; }
  bool accept(std::string_view symbol) {
    if (!is_symbol(symbol)) return false;
    advance();
    return true;
  }
  void expect(std::string_view symbol) {
    if (!accept(symbol)) throw Failure("'" + std::string(symbol) + "' is missing " + before_token());
  }
  std::string before_token() const {
    return token_.kind == TokenKind::end ? "at the end" : "before " + quoted_token();
  }
  std::string quoted_token() const {
    Budget budget;
    if (token_.kind == TokenKind::number) return text_of(token_.value, budget);
    return "'" + token_.text + "'";
  }
  [[noreturn]] void unexpected() const {
    for (const char* word : {"lambda", "for", "await", "yield"})
      if (is_name(word)) refuse_python(std::string("'") + word + "'");
    if (token_.kind == TokenKind::end) throw Failure("it ends too early");
    throw Failure("unexpected " + quoted_token());
  }

  static Node make(Kind kind, std::string text = {}) {
    Node node = std::make_unique<Expression>();
    node->kind = kind;
    node->text = std::move(text);
    return node;
  }
  static void add(Node& node, Node child) {
    if (child) node->depth = std::max(node->depth, child->depth + 1);
    if (node->depth > kMaxDepth)
      throw Failure("it is nested more than " + std::to_string(kMaxDepth) + " deep");
    node->children.push_back(std::move(child));
  }
  static Node binary(std::string name, Node a, Node b) {
    Node node = make(Kind::binary, std::move(name));
    add(node, std::move(a));
    add(node, std::move(b));
    return node;
  }

  Node tuple_or_single() {
    Node first = expression();
    if (!is_symbol(",")) return first;
    Node tuple = make(Kind::sequence);
    tuple->constant = true;
    add(tuple, std::move(first));
    while (accept(","))
      if (token_.kind != TokenKind::end && !is_symbol(")")) add(tuple, expression());
    return tuple;
  }

  // Called for each nested part; bounds the recursion of the parser itself.
  Node expression() {
    if (++level_ > kMaxDepth) throw Failure("it is nested more than " + std::to_string(kMaxDepth) + " deep");
    Node value = logical("or");
    if (is_name("if")) {
      advance();
      Node node = make(Kind::conditional);
      add(node, std::move(value));
      add(node, logical("or"));
      if (!is_name("else")) throw Failure("'else' is missing " + before_token());
      advance();
      add(node, expression());
      value = std::move(node);
    }
    --level_;
    return value;
  }

  Node logical(const char* word) {
    const bool is_or = std::string_view(word) == "or";
    Node first = is_or ? logical("and") : negation();
    if (!is_name(word)) return first;
    Node node = make(is_or ? Kind::logical_or : Kind::logical_and);
    add(node, std::move(first));
    while (is_name(word)) {
      advance();
      add(node, is_or ? logical("and") : negation());
    }
    return node;
  }

  Node negation() {
    size_t count = 0;
    for (; is_name("not"); ++count) advance();
    Node node = comparison();
    for (; count > 0; --count) {
      Node outer = make(Kind::unary, "not");
      add(outer, std::move(node));
      node = std::move(outer);
    }
    return node;
  }

  // The comparison operator at the token, which is consumed; empty if there is none.
  std::string comparison_operator() {
    for (const char* symbol : {"<", ">", "<=", ">=", "==", "!="})
      if (accept(symbol)) return symbol;
    if (is_name("in")) {
      advance();
      return "in";
    }
    if (is_name("is")) {
      advance();
      const bool negated = is_name("not");
      if (negated) advance();
      return negated ? "is not" : "is";
    }
    if (is_name("not")) {
      advance();
      if (!is_name("in")) unexpected();
      advance();
      return "not in";
    }
    return {};
  }

  Node comparison() {
    Node first = chain(0);
    Node node;
    for (std::string name = comparison_operator(); !name.empty(); name = comparison_operator()) {
      if (!node) {
        node = make(Kind::comparison);
        add(node, std::move(first));
      }
      node->keywords.push_back(name);
      add(node, chain(0));
    }
    return node ? std::move(node) : std::move(first);
  }

  // Left-associative operators, the weakest first.
  Node chain(size_t level) {
    static const std::array<std::vector<std::string_view>, 6> kLevels = {
        {{"|"}, {"^"}, {"&"}, {"<<", ">>"}, {"+", "-"}, {"*", "/", "//", "%"}}};
    if (level == kLevels.size()) return sign();
    Node node = chain(level + 1);
    while (token_.kind == TokenKind::symbol &&
           std::find(kLevels[level].begin(), kLevels[level].end(), token_.text) != kLevels[level].end()) {
      const std::string name = token_.text;
      advance();
      node = binary(name, std::move(node), chain(level + 1));
    }
    return node;
  }

  Node sign() {
    if (!is_symbol("+") && !is_symbol("-") && !is_symbol("~")) return power();
    if (++level_ > kMaxDepth) throw Failure("it is nested more than " + std::to_string(kMaxDepth) + " deep");
    Node node = make(Kind::unary, token_.text);
    advance();
    add(node, sign());
    --level_;
    return node;
  }

  // ** binds stronger than a sign before it, and weaker than one behind it.
  Node power() {
    Node base = postfix();
    if (!accept("**")) return base;
    if (++level_ > kMaxDepth) throw Failure("it is nested more than " + std::to_string(kMaxDepth) + " deep");
    Node exponent = sign();
    --level_;
    return binary("**", std::move(base), std::move(exponent));
  }

  Node postfix() {
    Node node = atom();
    while (true) {
      if (accept(".")) {
        if (token_.kind != TokenKind::name) unexpected();
        if (token_.text.starts_with("__")) refuse_python("the name " + token_.text);
        Node outer = make(Kind::attribute, token_.text);
        advance();
        add(outer, std::move(node));
        node = std::move(outer);
      } else if (accept("(")) {
        node = call(std::move(node));
      } else if (accept("[")) {
        node = subscript(std::move(node));
      } else {
        return node;
      }
    }
  }

  Node call(Node function) {
    Node node = make(Kind::call);
    add(node, std::move(function));
    while (!accept(")")) {
      if (is_symbol("*") || is_symbol("**")) refuse_python("unpacking by * in a call");
      Node argument = expression();
      if (is_symbol("=") && argument->kind == Kind::name) {
        advance();
        node->keywords.push_back(argument->text);
        argument = expression();
      } else if (!node->keywords.empty()) {
        throw Failure("an argument without name follows one with a name");
      }
      if (is_name("for")) unexpected();
      add(node, std::move(argument));
      if (!is_symbol(")")) expect(",");
    }
    return node;
  }

  Node subscript(Node object) {
    std::array<Node, 3> bounds;
    size_t colons = 0;
    while (!is_symbol("]")) {
      if (accept(":")) {
        if (++colons > 2) unexpected();
      } else if (!bounds[colons]) {
        bounds[colons] = expression();
      } else {
        unexpected();
      }
    }
    advance();
    if (colons == 0 && !bounds[0]) throw Failure("an index is missing between [ and ]");
    Node node = make(colons > 0 ? Kind::slice : Kind::index);
    add(node, std::move(object));
    for (size_t i = 0; i < (colons > 0 ? 3u : 1u); ++i) add(node, std::move(bounds[i]));
    return node;
  }

  Node atom() {
    if (token_.kind == TokenKind::number) {
      Node node = make(Kind::constant);
      node->constant = token_.value;
      advance();
      return node;
    }
    if (token_.kind == TokenKind::string) {
      std::string text;
      for (; token_.kind == TokenKind::string; advance()) text += token_.text;  // adjacent ones are joined
      Node node = make(Kind::constant);
      node->constant = std::move(text);
      return node;
    }
    if (token_.kind == TokenKind::name) return name();
    if (accept("(")) {
      if (accept(")")) {
        Node tuple = make(Kind::sequence);
        tuple->constant = true;
        return tuple;
      }
      Node inner = tuple_or_single();
      if (is_name("for")) unexpected();
      expect(")");
      return inner;
    }
    if (accept("[")) {
      Node list = make(Kind::sequence);
      list->constant = false;
      while (!accept("]")) {
        add(list, expression());
        if (is_name("for")) unexpected();
        if (!is_symbol("]")) expect(",");
      }
      return list;
    }
    unexpected();
  }

  Node name() {
    for (const char* word : {"lambda", "for", "if", "else", "and", "or", "not", "in", "is"})
      if (is_name(word)) unexpected();
    if (token_.text.starts_with("__")) refuse_python("the name " + token_.text);
    Node node;
    if (is_name("True") || is_name("False") || is_name("None")) {
      node = make(Kind::constant);
      if (!is_name("None")) node->constant = is_name("True");
    } else {
      node = make(Kind::name, token_.text);
    }
    advance();
    return node;
  }

  Lexer lexer_;
  Token token_;
  size_t level_ = 0;
};

}  // namespace

void refuse_python(const std::string& what) {
  throw Failure(what + " is Python that fire3dv-convert does not evaluate", Failure::Kind::unsupported);
}

std::unique_ptr<Expression> parse_expression(std::string_view text) {
  if (text.size() > kMaxLength)
    throw Failure("the expression has more than " + std::to_string(kMaxLength) + " characters");
  return Parser(text).parse();
}

}  // namespace fire3dv::convert::xacro
