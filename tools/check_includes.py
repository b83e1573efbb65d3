#!/usr/bin/env python3
"""Standard headers of the names that each C++ file uses.

    check_includes.py [FILE ...]     all C++ files of the tree, or those named; exit 1 if a header is missing

A file that uses a name of the standard library includes its header, or a header of this tree that does. What another header of the
standard library or of a third party brings along differs between versions: g++ 12 finds std::stable_sort by way of <functional>,
g++ 14 does not.
"""
import functools
import os
import re
import subprocess
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))

# Names by header. A name of several headers needs one of them.
HEADERS = {
    "algorithm": """adjacent_find all_of any_of binary_search clamp copy_backward copy_if copy_n count count_if equal_range fill fill_n find_end
        find find_first_of find_if find_if_not for_each for_each_n generate generate_n includes inplace_merge is_heap is_partitioned is_permutation
        is_sorted is_sorted_until lexicographical_compare lower_bound make_heap max_element merge min_element minmax minmax_element
        mismatch move_backward next_permutation none_of nth_element partial_sort partition partition_copy partition_point pop_heap
        prev_permutation push_heap remove_copy remove_copy_if remove_if replace replace_copy replace_if reverse reverse_copy rotate rotate_copy sample
        search search_n set_difference set_intersection set_symmetric_difference set_union shift_left shift_right shuffle sort sort_heap
        stable_partition stable_sort swap_ranges transform unique unique_copy upper_bound""",
    "any": "any any_cast make_any",
    "array": "array to_array",
    "atomic": """atomic atomic_bool atomic_flag atomic_fence atomic_signal_fence atomic_thread_fence atomic_uint32_t atomic_uint64_t memory_order
        memory_order_acq_rel memory_order_acquire memory_order_relaxed memory_order_release memory_order_seq_cst atomic_ref""",
    "bit": "bit_cast bit_ceil bit_floor bit_width countl_one countl_zero countr_one countr_zero endian has_single_bit popcount rotl rotr",
    "bitset": "bitset",
    "cctype": "isalnum isalpha isdigit isspace isupper islower isprint isxdigit tolower toupper",
    "charconv": "chars_format from_chars from_chars_result to_chars to_chars_result",
    "chrono": "chrono",
    "cmath": """abs acos acosh asin asinh atan atan2 atanh cbrt ceil copysign cos cosh erf exp exp2 expm1 floor fma fmax fmin fmod frexp hypot
        ilogb isfinite isinf isnan isnormal ldexp llround lround log log10 log1p log2 logb lrint modf nearbyint nextafter pow
        remainder rint round scalbn signbit sin sinh sqrt tan tanh trunc""",
    "complex": "complex",
    "condition_variable": "condition_variable condition_variable_any cv_status",
    "csignal": "signal raise sig_atomic_t",
    "cstdint": """int8_t int16_t int32_t int64_t uint8_t uint16_t uint32_t uint64_t intptr_t uintptr_t intmax_t uintmax_t INT32_MAX INT64_MAX
        UINT8_MAX UINT16_MAX UINT32_MAX UINT64_MAX INT32_MIN INT64_MIN""",
    "cstdio": """FILE fclose fflush fopen fprintf fputc fputs fread fseek ftell fwrite getchar perror printf putchar puts remove rename snprintf
        stderr stdout vfprintf vsnprintf fgets fileno tmpfile sscanf""",
    "cstdlib": "_Exit abort aligned_alloc atexit atof atoi calloc div exit free getenv llabs malloc quick_exit realloc strtod strtof strtol strtoll "
               "strtoul strtoull system EXIT_FAILURE EXIT_SUCCESS",
    "cstring": """memchr memcmp memcpy memmove memset strcat strchr strcmp strcpy strcspn strerror strlen strncmp strncpy strrchr strspn
        strstr strtok""",
    "ctime": "clock ctime gmtime localtime mktime strftime time tm",
    "deque": "deque",
    "exception": "current_exception exception exception_ptr rethrow_exception set_terminate terminate uncaught_exceptions",
    "filesystem": "filesystem",
    "fstream": "basic_ifstream fstream ifstream ofstream filebuf",
    "functional": """bind bind_front cref equal_to function greater greater_equal hash invoke less less_equal mem_fn minus multiplies negate
        not_equal_to not_fn plus ref reference_wrapper""",
    "future": "async future packaged_task promise shared_future launch",
    "initializer_list": "initializer_list",
    "iomanip": "get_time put_time quoted setfill setprecision setw",
    "iostream": "cerr cin clog cout",
    "iterator": "back_inserter distance front_inserter inserter istream_iterator istreambuf_iterator make_move_iterator next ostream_iterator "
                "ostreambuf_iterator prev reverse_iterator move_iterator advance",
    "latch": "latch",
    "limits": "numeric_limits",
    "list": "list",
    "locale": "locale",
    "map": "map multimap",
    "memory": """addressof align allocator default_delete destroy destroy_at dynamic_pointer_cast enable_shared_from_this make_shared
        make_unique shared_ptr static_pointer_cast uninitialized_copy unique_ptr weak_ptr allocator_traits construct_at""",
    "memory_resource": "pmr",
    "mutex": "call_once lock_guard mutex once_flag recursive_mutex scoped_lock timed_mutex unique_lock defer_lock try_to_lock adopt_lock",
    "new": "align_val_t bad_alloc nothrow hardware_destructive_interference_size launder",
    "numbers": "numbers",
    "numeric": "accumulate adjacent_difference exclusive_scan gcd inclusive_scan inner_product iota lcm midpoint partial_sum reduce transform_reduce",
    "optional": "make_optional nullopt nullopt_t optional",
    "queue": "priority_queue queue",
    "random": """bernoulli_distribution default_random_engine discrete_distribution exponential_distribution mt19937 mt19937_64 normal_distribution
        poisson_distribution random_device uniform_int_distribution uniform_real_distribution minstd_rand seed_seq""",
    "ranges": "views",
    "ratio": "ratio milli micro nano",
    "regex": "cmatch regex regex_match regex_replace regex_search smatch sregex_iterator",
    "semaphore": "binary_semaphore counting_semaphore",
    "set": "multiset set",
    "shared_mutex": "shared_lock shared_mutex",
    "source_location": "source_location",
    "span": "as_bytes as_writable_bytes dynamic_extent span",
    "sstream": "istringstream ostringstream stringstream",
    "stack": "stack",
    "stdexcept": "domain_error invalid_argument length_error logic_error out_of_range overflow_error range_error runtime_error",
    "stop_token": "stop_callback stop_source stop_token",
    "string": "char_traits getline stod stof stoi stol stoll stoul stoull string to_string u16string u32string wstring u8string",
    "string_view": "string_view",
    "system_error": "errc error_category error_code generic_category make_error_code system_category system_error",
    "thread": "jthread this_thread thread",
    "tuple": "forward_as_tuple make_tuple tie tuple tuple_cat apply",
    "type_traits": """common_type_t conditional_t decay_t enable_if_t false_type integral_constant invoke_result_t is_arithmetic_v is_base_of_v
        is_class_v is_const_v is_constructible_v is_convertible_v is_enum_v is_floating_point_v is_integral_v is_invocable_v is_same is_same_v
        is_signed_v is_standard_layout_v is_trivially_copyable is_trivially_copyable_v is_unsigned_v is_void_v make_signed_t make_unsigned_t
        is_trivially_destructible_v remove_const_t remove_cv_t remove_cvref_t remove_pointer_t remove_reference_t true_type type_identity_t
        underlying_type_t void_t is_empty_v is_copy_constructible_v is_nothrow_move_constructible_v is_aggregate_v is_array_v""",
    "typeindex": "type_index",
    "unordered_map": "unordered_map unordered_multimap",
    "unordered_set": "unordered_multiset unordered_set",
    "utility": "as_const cmp_equal cmp_greater cmp_less declval exchange in_place in_place_t index_sequence index_sequence_for integer_sequence "
               "make_index_sequence make_pair pair piecewise_construct in_place_type unreachable",
    "variant": "bad_variant_access get_if holds_alternative monostate variant variant_size_v visit",
    "vector": "vector",
}
# Headers whose names are also used without std::.
BARE = {"cstdint"}
# Names that several headers declare; any one suffices.
SEVERAL = {
    "abs": {"cmath", "cstdlib"}, "errc": {"system_error", "charconv"}, "error_code": {"system_error", "filesystem"},
    "hash": {"functional", "string", "string_view", "memory", "optional", "variant", "filesystem"},
    "in_place": {"utility", "optional", "variant"}, "in_place_t": {"utility", "optional"}, "less": {"functional", "map", "set"},
    "pair": {"utility", "map", "unordered_map"}, "remove": {"cstdio", "algorithm"}, "string_view": {"string_view", "string"},
}
# C headers with the same declarations in the global namespace, and headers that must include the other.
ALSO = {"cstdint": {"stdint.h", "inttypes.h", "cinttypes"}, "cstdio": {"stdio.h"}, "cstdlib": {"stdlib.h"}, "cstring": {"string.h"},
        "cmath": {"math.h"}, "ctime": {"time.h"}, "csignal": {"signal.h"}, "ratio": {"chrono"}, "stop_token": {"thread", "condition_variable"},
        "exception": {"stdexcept", "new", "system_error", "string", "vector", "memory", "functional", "optional", "variant"},
        "initializer_list": {"vector", "string", "map", "set", "utility", "array", "span"}}
NAMES = {name: {header} for header, names in HEADERS.items() for name in names.split()} | SEVERAL
BARE_NAMES = {name for header in BARE for name in HEADERS[header].split()}

INCLUDE = re.compile(r'^[ \t]*#[ \t]*include[ \t]*([<"])([^>"]+)[>"]', re.MULTILINE)
# Comments and literals, which do not count as uses.
TEXT = re.compile(r'//[^\n]*|/\*.*?\*/|R"([^(\s]*)\(.*?\)\1"|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])\'', re.DOTALL)
USE = re.compile(r"(?<![\w:])(?:std::(?:ranges::)?(\w+)|(%s)\b)" % "|".join(sorted(BARE_NAMES)))


@functools.lru_cache(maxsize=None)
def parsed(path):
    """Headers of others, files of this tree that a file includes, and names that it uses with the first line of each."""
    with open(path, encoding="utf-8") as file:
        text = file.read()
    others, ours = set(), []
    for bracket, name in INCLUDE.findall(text):
        near = next((p for p in (os.path.join(ROOT, name), os.path.join(os.path.dirname(path), name),
                                 os.path.join(ROOT, "adapters/generic/include", name)) if os.path.isfile(p)), None)
        if near:
            ours.append(os.path.normpath(near))
        elif bracket == "<":
            others.add(name)
    text = TEXT.sub(lambda match: "\n" * match.group().count("\n") or " ", text)
    uses = {}
    for match in USE.finditer(INCLUDE.sub("", text)):
        name = match.group(1) or match.group(2)
        if name in NAMES:
            uses.setdefault(name, text.count("\n", 0, match.start()) + 1)
    return others, ours, uses


def headers_of(path):
    found, open_files, seen = set(), [path], {path}
    while open_files:
        others, ours, _ = parsed(open_files.pop())
        found |= others
        for file in ours:
            if file not in seen:
                seen.add(file)
                open_files.append(file)
    return found


def missing(path):
    """(line, name, header) of what a file uses without a header for it; one name for each header."""
    there = headers_of(path)
    said = set()
    for name, line in sorted(parsed(path)[2].items(), key=lambda use: use[1]):
        wanted = NAMES[name]
        enough = wanted.union(*(ALSO.get(header, set()) for header in wanted))
        first = next(header for header, names in HEADERS.items() if name in names.split())
        if not enough & there and first not in said:
            said.add(first)
            yield line, name, first


def files_of_tree():
    listing = subprocess.run(["git", "ls-files", "-co", "--exclude-standard", "*.h", "*.hpp", "*.cpp"], cwd=ROOT, capture_output=True, text=True)
    names = listing.stdout.split("\n") if listing.returncode == 0 else [
        os.path.relpath(os.path.join(folder, name), ROOT)
        for top in ("adapters", "base", "convert", "examples", "programs", "protocol", "renderer", "tests", "tools")
        for folder, _, files in os.walk(os.path.join(ROOT, top)) for name in files if name.endswith((".h", ".hpp", ".cpp"))]
    return [os.path.join(ROOT, name) for name in names if name and os.path.isfile(os.path.join(ROOT, name))]


def main():
    if "-h" in sys.argv[1:] or "--help" in sys.argv[1:]:
        print(__doc__)
        return 0
    files = [os.path.abspath(path) for path in sys.argv[1:]] or files_of_tree()
    faults = 0
    for path in sorted(files):
        for line, name, header in missing(path):
            faults += 1
            print(f"{os.path.relpath(path, ROOT)}:{line}: {name} is used: add #include <{header}>")
    print(f"check_includes: {len(files)} files, {faults} missing")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
