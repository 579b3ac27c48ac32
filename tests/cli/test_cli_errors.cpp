// Every mistake of a user ends with an exit status other than 0, one line on stderr that says what is wrong, nothing on
// stdout, and no file changed.

#include "program_run.h"

#include "check.h"

using cli::scratch;

// Status 2: the command line is wrong; 1: the work failed.
static void expect_failure(const std::string& arguments, int status, const std::string& message,
                           const std::string& environment = "") {
    const cli::Result result = cli::run(arguments, environment);
    const bool is_one_line = !result.errors.empty() && result.errors.find('\n') == result.errors.size() - 1;
    const bool has_prefix = result.errors.rfind("pliant: ", 0) == 0;
    if (result.status != status || !is_one_line || !has_prefix || result.errors.find(message) == std::string::npos ||
        !result.output.empty()) {
        fail_msg("pliant %s: exit status %d (wanted %d), stdout '%s', stderr '%s' (wanted '%s')", arguments.c_str(),
                 result.status, status, result.output.c_str(), result.errors.c_str(), message.c_str());
    }
}

static void test_cli_subcommands(void**) {
    expect_failure("", 2, "A subcommand is required (see pliant --help)");
    expect_failure("fly", 2, "there is no subcommand named fly");
    expect_failure("--bogus", 2, "pliant --help");
    expect_failure("list --bogus", 2, "not expected: --bogus (see pliant list --help)");
    expect_failure("run", 2, "scene is required (see pliant run --help)");
    expect_failure("run Bunny Cloth", 2, "not expected: Cloth");
    expect_failure("compare", 2, "scenes is required (see pliant compare --help)");
    expect_failure("bench", 1, "bench takes either names of scenes or --series");
    expect_failure("bench Bunny --series sheet", 1, "bench takes either names of scenes or --series");
    expect_failure("bench --series cube", 2, "--series: cube not in {sheet,sphere,bodies,");
}

static void test_cli_scene_names(void**) {
    expect_failure("run Bunnny", 1, "there is no scene named Bunnny; did you mean Bunny?");
    expect_failure("run coll", 1, "did you mean Collide or Collide2 or Collide3?");
    expect_failure("run xyzzy", 1, "there is no scene named xyzzy; pliant list shows all");
    expect_failure("run ''", 1, "there is no scene named ");
    expect_failure("compare Bunny Pressur", 1, "there is no scene named Pressur; did you mean Pressure?");
    expect_failure("bench all nowhere", 1, "there is no scene named nowhere");
    expect_failure("compare all nowhere", 1, "there is no scene named nowhere");
}

static void test_cli_frames(void**) {
    for (const char* value : {"0", "-3", "abc", "1.5", "99999999999999", "''"}) {
        expect_failure("run Bunny --frames " + std::string(value), 2, "--frames: ");
    }
    expect_failure("run Bunny --frames", 2, "--frames: 1 required N missing");
    expect_failure("compare Bunny --frames 0", 2, "--frames: Value 0 not in range 1 to 1000000");
    expect_failure("bench Bunny --frames 0", 2, "--frames: Value 0 not in range 1 to 1000000");
    expect_failure("demo --frames 0", 2, "--frames: Value 0 not in range 1 to 1000000");
}

static void test_cli_engines(void**) {
    expect_failure("run Bunny --engine physx", 2, "--engine: physx not in {pliant,bullet}");
    expect_failure("run Bunny --engine bullet --reference", 1, "--reference is a mode of Pliant");
}

static void test_cli_solvers(void**) {
    expect_failure("run Bunny --solver cuda", 2, "--solver: cuda not in {position-based,implicit,xpbd}");
    expect_failure("bench Bunny --threads 0", 2, "--threads: Value 0 not in range 1 to 256");
    expect_failure("run Bunny --substeps 0", 2, "--substeps: Value 0 not in range 1 to 1000");
    expect_failure("compare Bunny --iterations -1", 2, "--iterations: Value -1 not in range 0 to 10000");
    for (const char* value : {"0", "-0.1", "1e-9", "2", "nan", "inf", "soon"}) {
        expect_failure("run Bunny --dt " + std::string(value), 2, "--dt: ");
    }
    expect_failure("run ClothAttach --solver implicit --iterations 0", 1, "sweeps is 0, at least 1 is needed");
    expect_failure("run ClothAttach --solver xpbd --iterations 0", 1, "sweeps is 0, at least 1 is needed");
    expect_failure("run ClothAttach --iterations 0", 1, "--iterations 0 would leave links and contacts unsolved");
    expect_failure("run ClothAttach --substeps 4", 1, "--substeps are those of --solver xpbd");
    expect_failure("run ClothAttach --engine bullet --solver xpbd", 1, "btSoftBody has no solver xpbd");
    expect_failure("run ClothAttach --reference --solver implicit", 1, "does not go with --solver implicit");
}

static void test_cli_changes_of_scenes(void**) {
    expect_failure("run Flag --self-collision maybe", 2, "--self-collision: maybe not in {on,off,nodes,grids,faces}");
    for (const char* value : {"1", "0", "x", "20x", "x20", "20x1", "1001", "20x20x20", "-5", "2e3", "''"}) {
        expect_failure("run Flag --resolution " + std::string(value), 2, "--resolution: ");
    }
    expect_failure("run Bunny --resolution 20", 1, "scene Bunny has no grid whose resolution could be chosen");
    expect_failure("run Bunny --self-collision off", 1, "scene Bunny has no self-collision that could be chosen");
    expect_failure("run Flag --engine bullet --self-collision faces", 1, "btSoftBody has no self-collision of faces");
}

static void test_cli_mesh_files(void**) {
    const std::string missing = scratch("missing.obj"), cut = scratch("cut.obj"), nan = scratch("nan.obj"),
                      empty = scratch("empty.obj");
    expect_failure("run Bunny --mesh " + missing, 1, missing + ": No such file or directory");
    cli::write_file(cut, cli::read_file(PLIANT_DATA_DIR "/bunny.obj").substr(0, 9000));
    expect_failure("run Bunny --mesh " + cut, 1, cut);
    cli::write_file(nan, "v 0 0 0\nv nan 0 0\nv 0 1 0\nf 1 2 3\n");
    expect_failure("run Bunny --mesh " + nan, 1, nan);
    cli::write_file(empty, "");
    expect_failure("run Bunny --mesh " + empty, 1, empty);
    expect_failure("run Bunny --mesh " + scratch(""), 1, "scene Bunny: ");
    expect_failure("run Cloth --mesh " PLIANT_DATA_DIR "/bunny.obj", 1, "scene Cloth has no triangle mesh");
    expect_failure("run Cloth --tetra box", 1, "scene Cloth has no tetrahedral mesh");
    expect_failure("run Bunny --mesh", 2, "--mesh: 1 required FILE missing");
    expect_failure("compare Bunny --mesh " + cut, 2, "not expected");
}

// The frames are more than could be run in the time of the test: the failure comes before the work.
static void test_cli_unwritable_outputs(void**) {
    const std::string endless = "run Bunny --frames 1000000 ";
    expect_failure(endless + "--png " + scratch("no/such/folder.png"), 1,
                   "cannot write " + scratch("no/such/folder.png"));
    expect_failure(endless + "--csv " + scratch(""), 1, "it is a folder");
    expect_failure(endless + "--png " + scratch("same") + " --csv " + scratch("./same"), 1, "name the same file");
    expect_failure("compare Bunny --frames 1000000 --csv " + scratch("no/such.csv"), 1, "cannot write ");
    cli::write_file(scratch("file"), "kept");
    expect_failure("demo --frames 1000000 --out " + scratch("file"), 1, scratch("file"));
    expect_failure("demo --frames 1000000 --out " + scratch("file/below"), 1, "cannot make the folder ");
    assert_string_equal(cli::read_file(scratch("file")).c_str(), "kept");
}

static void test_cli_full_disk(void**) {
    expect_failure("list >/dev/full", 1, "standard output cannot be written");
    expect_failure("run Bending --engine bullet --frames 1 --csv /dev/full", 1,
                   "cannot write /dev/full: No space left");
}

static void test_cli_without_opengl(void**) {
    const std::string png = scratch("picture.png");
    cli::write_file(png, "kept");
    // No vendor of EGL at all, and Mesa without its drivers.
    expect_failure("run Bunny --frames 1000000 --png " + png, 1, "pictures need EGL",
                   "__EGL_VENDOR_LIBRARY_DIRS=/nonexistent");
    expect_failure("run Bunny --frames 1000000 --png " + png, 1, "pictures need EGL",
                   "LIBGL_DRIVERS_PATH=/nonexistent");
    assert_string_equal(cli::read_file(png).c_str(), "kept");
    assert_int_equal(cli::run("run Bending --frames 1 --engine bullet", "LIBGL_DRIVERS_PATH=/nonexistent").status, 0);
}

static void test_cli_failures_leave_no_file(void**) {
    const std::string before = cli::scratch_files();
    expect_failure("run Bunny --mesh " + scratch("missing.obj") + " --csv " + scratch("new.csv") + " --png " +
                       scratch("new.png"),
                   1, "No such file or directory");
    assert_string_equal(cli::scratch_files().c_str(), before.c_str());
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_cli_subcommands),
        cmocka_unit_test(test_cli_scene_names),
        cmocka_unit_test(test_cli_frames),
        cmocka_unit_test(test_cli_engines),
        cmocka_unit_test(test_cli_solvers),
        cmocka_unit_test(test_cli_changes_of_scenes),
        cmocka_unit_test(test_cli_mesh_files),
        cmocka_unit_test(test_cli_unwritable_outputs),
        cmocka_unit_test(test_cli_full_disk),
        cmocka_unit_test(test_cli_without_opengl),
        cmocka_unit_test(test_cli_failures_leave_no_file),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
