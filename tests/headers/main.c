/* The program that the headers are linked into: that it links is the test. */
int main(void) {
    return 0;
}
